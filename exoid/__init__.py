"""One door to everything a notebook needs.

    import exoid

    leg = exoid.Model.standard(thigh_length=0.40)
    found = exoid.discover(leg, ["run1.csv", "run2.csv", "run3.csv"], verify="run4.csv")
    found.report("out")

the leg          `Model`, `Effect`, `Coefficient`, `Shape`, `Limits`, `Motion`, `catalogue`, `read_model`, `write_model`
any machine      `Joint`, `Payload`, `Body` (the limb of a wearer); its equations and code: `mechanics`, `equations`,
                 `regressor`, `check_equations`, `compiled`
measurements     `read_recording`, `Recording`, `Finding`, `write_recording`; the virtual bench: `Bench`, `Hidden`,
                 `simulate`, `simulate_runs`, `draw_hidden`, `Wearer`, `Walk`
numbers          `prepare`, `identify`, `Fit`, `rivals`; motions to record: `design`, `evaluate`, `evaluate_paper`
the paper        `reproduce_paper`, `paper_items`: its figures, tables and equations, made again
what is missing  `compare`, `diagnose`, `discover`, `add`, `watch`, `separate`; all of one preparation: `Session`;
                 a fit with its errors: `fitted_model`
figures          `figure_style`, `new_figure`, `label`
bad input        `ExoidError`: what is wrong, where, what to do

Wherever recordings are asked for, paths, folders, DataFrames, mappings {name: array} and arrays will do, one or many.
`dir(exoid)` shows what is used most. Every name lives in one of the packages `exoid.symbolic`, `exoid.measurement`,
`exoid.optimisation` and `exoid.diagnosis`, which can be imported from as well, and is loaded at its first use:
`import exoid` itself costs nothing.
"""

_ELSEWHERE = {
    "ExoidError": "exoid.ground.errors",
    "figure_style": "exoid.ground.figures",
    "label": "exoid.ground.figures",
    "new_figure": "exoid.ground.figures",
    "__version__": "exoid.ground.version",
    "mechanics": "exoid.symbolic.mechanics.lagrange",  # `exoid.symbolic.mechanics` is a folder
}

_USED = (
    "Bench", "Coefficient", "Effect", "ExoidError", "Joint", "Model", "Payload", "Recording", "Session", "Shape",
    "add", "catalogue", "compare", "compare_against", "design", "diagnose", "discover", "equations", "follow",
    "identify", "prepare", "read_model", "read_recording", "read_recordings", "replay", "reproduce_paper", "rivals",
    "separate", "simulate", "simulate_runs", "write_model", "write_recording",
)  # fmt: skip
"""What `dir(exoid)` and completion show; every other public name is found as well when it is asked for."""

_PACKAGES = ("symbolic", "measurement", "optimisation", "diagnosis")


def __getattr__(name: str) -> object:
    """Look a name up in the packages at its first use (PEP 562); AttributeError where none of them has it.

    Nothing is imported before: `python -m exoid` has the current folder on its path until `__main__` removes it.
    """
    from importlib import import_module

    if name in _ELSEWHERE:
        return getattr(import_module(_ELSEWHERE[name]), name)
    if name == "__all__" or not name.startswith("_"):
        homes = {}
        from exoid.ground.folder import apps

        for package in (*_PACKAGES, *(f"apps.{app}" for app in apps())):
            module = import_module(f"exoid.{package}")
            homes |= dict.fromkeys(getattr(module, "__all__", ()), module)
        if name == "__all__":
            return [*homes, *_ELSEWHERE]
        if name in homes:
            return getattr(homes[name], name)
    raise AttributeError(f"module 'exoid' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({"__version__", *_USED} & {"__version__", *__getattr__("__all__")})  # type: ignore[misc]
