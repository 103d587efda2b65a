"""A language model in a process of its own: llama.cpp's HTTP server on this machine alone.

    python -m swarmscout.llm.embedded_server MODEL.gguf THREADS CONTEXT

reads a key from its first line of input, prints its address, and ends when its input ends: so it
never outlives the process that started it.
"""

from __future__ import annotations

import sys

__all__ = ["main"]


def main() -> None:
    """Serve until the input ends."""
    import xllamacpp

    path, threads, context = sys.argv[1], int(sys.argv[2]), int(sys.argv[3])
    parameters = xllamacpp.CommonParams()
    parameters.model.path = path
    parameters.api_keys = [sys.stdin.readline().strip()]
    parameters.n_ctx = context
    # Temperature 0 gives the same answer again only if a request is computed by itself, from its
    # beginning, and by a fixed number of threads.
    parameters.n_parallel = 1
    parameters.cache_prompt = False
    parameters.cpuparams.n_threads = threads
    parameters.cpuparams_batch.n_threads = threads
    parameters.warmup = False
    parameters.ui = False
    parameters.verbosity = 0
    server = xllamacpp.Server(parameters)
    print(server.listening_address, flush=True)
    sys.stdin.read()


if __name__ == "__main__":
    main()
