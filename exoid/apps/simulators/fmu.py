"""A model as an FMU, in which simulators exchange models (fmi-standard.org): what it holds, and how it is packed.

Variables lie in one array of the C; a variable's place is its value reference: 0 is time, then inputs, states, and what
is computed. Sources and description are inside, and the binary of this machine where it has a C compiler.
"""

from __future__ import annotations

import hashlib
import io
import platform
import sys
import tempfile
import warnings
import zipfile
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from xml.sax.saxutils import escape, quoteattr

from exoid.ground.text import filled
from exoid.symbolic.codegen.compiler import CompilerError, find_compiler
from exoid.symbolic.units import BASE, dimension

VERSIONS = ("2.0", "3.0")
INPUT, STATE, RATE, OUTPUT = "input", "state", "rate", "output"
"""Roles of variables. A rate is the derivative of the state at the same place among the states."""
FLAGS = ("-std=c99", "-O2", "-fPIC", "-ffp-contract=off", "-fvisibility=hidden")
EPOCH = (1980, 1, 1, 0, 0, 0)
"""Time stamp of everything inside: the same model gives the same file."""
SYSTEMS = {"linux": ("linux", "linux"), "darwin": ("darwin", "darwin"), "win32": ("win", "windows")}
"""What FMI 2.0 and FMI 3.0 call operating systems."""
ENDINGS = {"darwin": ".dylib", "win32": ".dll"}


@dataclass(frozen=True)
class FmuVariable:
    """A variable: its name, one of the roles, its unit, its meaning, and its value at the start."""

    name: str
    role: str
    unit: str
    about: str
    start: float = 0.0


@dataclass(frozen=True)
class FmuModel:
    """The contents of an FMU: a `name`, which is that of its file and its C, the `variables` in their order, C
    `sources` {file: text}, and the statements of each part of `fmu_model.c.in` by its key. `period` s is that of its
    samples, None where it is continuous.
    """

    name: str
    title: str
    variables: tuple[FmuVariable, ...]
    sources: Mapping[str, str] = field(repr=False)
    parts: Mapping[str, str] = field(repr=False)
    period: float | None = None

    def of(self, *roles: str) -> list[int]:
        """Return the value references of the variables in these roles."""
        return [k for k, variable in enumerate(self.variables, 1) if variable.role in roles]


def fmu_bytes(model: FmuModel, version: str) -> bytes:
    """Return the FMU of a version of FMI: a ZIP archive with description, sources and the binary of this machine."""
    sources = {**model.sources, "fmu.c": _source(model, version)}
    files = {f"sources/{name}": text.encode() for name, text in sources.items()}
    describe = _description_2 if version == "2.0" else _description_3
    files["modelDescription.xml"] = describe(model, _compiled_files(sources)).encode()
    if version == "3.0":
        files["sources/buildDescription.xml"] = _build_description(model, _compiled_files(sources)).encode()
    files |= _binary(model, sources, version)
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        for name in sorted(files):
            archive.writestr(zipfile.ZipInfo(name, EPOCH), files[name], zipfile.ZIP_DEFLATED)
    return buffer.getvalue()


def _compiled_files(sources: Iterable[str]) -> list[str]:
    return sorted(name for name in sources if name.endswith(".c"))


def _token(model: FmuModel) -> str:
    """Return the token that ties description and binary together: it changes with anything that either holds."""
    told = [model.name, model.title, repr(model.variables), repr(model.period)]
    told += [part for name in sorted(model.sources) for part in (name, model.sources[name])]
    return hashlib.sha256("\n".join([*told, *map(str, sorted(model.parts.items()))]).encode()).hexdigest()[:32]


def _source(model: FmuModel, version: str) -> str:
    """Return the C of the FMU: the model's glue with the functions of this version of FMI."""
    states, rates = model.of(STATE), model.of(RATE)
    headers = "\n".join(f'#include "{name}"' for name in sorted(model.sources) if name.endswith(".h"))
    start = ", ".join(["0.0", *(repr(float(variable.start)) for variable in model.variables)])
    here = Path(__file__)
    text = filled(here.with_name("fmu_model.c.in").read_text("utf-8"), {
        "INTERFACE": here.with_name(f"fmi{version[0]}.c.in").read_text("utf-8").rstrip(),
        "TITLE": escape(model.title).replace("*/", ""), "INCLUDES": headers, "NV": len(model.variables) + 1,
        "NX": len(states), "X": states[0] if states else 0, "DX": rates[0] if rates else 0,
        "LAST_SET": max(model.of(INPUT, STATE), default=0), "SAMPLED": int(model.period is not None),
        "PERIOD": repr(model.period or 1.0), "START": start, "TOKEN": _token(model), **model.parts,
    })  # fmt: skip
    return text


def _binary(model: FmuModel, sources: Mapping[str, str], version: str) -> dict[str, bytes]:
    """Return {place in the archive: content} of the library for this machine; nothing where it cannot be compiled."""
    compiler, system = find_compiler(), SYSTEMS.get(sys.platform)
    if compiler is None or system is None:
        return {}
    wide = sys.maxsize > 2**32
    old = f"{system[0]}{64 if wide else 32}"
    machine = {"amd64": "x86_64", "arm64": "aarch64"}.get(platform.machine().lower(), platform.machine().lower())
    place = old if version == "2.0" else f"{machine}-{system[1]}"
    ending = ENDINGS.get(sys.platform, ".so")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for file, text in sources.items():
            (folder / file).write_text(text, encoding="utf-8")
        whole = folder / "whole.c"
        whole.write_text("".join(f'#include "{file}"\n' for file in _compiled_files(sources)), encoding="utf-8")
        target = folder / f"{model.name}{ending}"
        try:
            compiler.build(whole, target, FLAGS)
        except CompilerError as error:
            warnings.warn(f"the FMU has sources only: {error}", UserWarning, stacklevel=2)
            return {}
        return {f"binaries/{place}/{target.name}": target.read_bytes()}


def _units(model: FmuModel) -> str:
    """Return the definitions of all units, the same in both versions."""
    lines = []
    for unit in sorted({variable.unit for variable in model.variables} | {"s"}):
        powers = dict(zip(BASE, dimension(unit, unit).powers, strict=True))
        powers["rad"] = unit.startswith("rad") - unit.count("/rad")
        told = "".join(f' {name}="{int(power)}"' for name, power in powers.items() if power)
        lines.append(f"    <Unit name={quoteattr(unit)}><BaseUnit{told}/></Unit>")
    return "\n".join(["  <UnitDefinitions>", *lines, "  </UnitDefinitions>"])


def _kinds(model: FmuModel, extra: str) -> str:
    """Return the elements that say what it can do: model exchange and co-simulation."""
    shared = f'modelIdentifier="{model.name}" canGetAndSetFMU{"S" if extra == "3.0" else "s"}tate="true"'
    step = "" if model.period is None or extra == "2.0" else f' fixedInternalStepSize="{model.period!r}"'
    variable = ' canHandleVariableCommunicationStepSize="true"'
    return f"  <ModelExchange {shared}@SOURCES@\n  <CoSimulation {shared}{variable}{step}@SOURCES@"


def _head(model: FmuModel, version: str, token: str) -> str:
    return (
        f'<?xml version="1.0" encoding="UTF-8"?>\n<fmiModelDescription fmiVersion="{version}" '
        f'modelName="{model.name}" {token}="{_token(model)}" description={quoteattr(model.title)} '
        'generationTool="exoid" variableNamingConvention="structured"'
    )


def _experiment(model: FmuModel) -> str:
    return f'  <DefaultExperiment startTime="0.0" stopTime="10.0" stepSize="{model.period or 0.01!r}"/>'


def _traits(model: FmuModel, one: FmuVariable) -> str:
    """Return causality, variability and initial of a variable."""
    flow = "continuous" if model.period is None else "discrete"
    return {
        INPUT: 'causality="input" variability="continuous"',
        STATE: 'causality="output" variability="continuous" initial="exact"',
        RATE: 'causality="output" variability="continuous" initial="calculated"',
        OUTPUT: f'causality="output" variability="{flow}" initial="calculated"',
    }[one.role]


def _description_2(model: FmuModel, compiled: Sequence[str]) -> str:
    """Return the modelDescription.xml of FMI 2.0."""
    states, first = model.of(STATE), model.of(RATE)[:1]
    lines = [
        '    <ScalarVariable name="time" valueReference="0" causality="independent" variability="continuous">'
        '<Real unit="s"/></ScalarVariable>'
    ]
    for k, item in enumerate(model.variables, 1):
        start = f' start="{item.start!r}"' if item.role in (INPUT, STATE) else ""
        rate = f' derivative="{states[k - first[0]] + 1}"' if item.role == RATE else ""
        lines.append(
            f'    <ScalarVariable name={quoteattr(item.name)} valueReference="{k}" {_traits(model, item)} '
            f"description={quoteattr(item.about)}><Real unit={quoteattr(item.unit)}{start}{rate}/></ScalarVariable>"
        )

    def listed(head: str, places: Sequence[int]) -> list[str]:
        inside = [f'      <Unknown index="{place + 1}"/>' for place in places]
        return [f"    <{head}>", *inside, f"    </{head}>"] if inside else []

    files = "".join(f'<File name="{name}"/>' for name in compiled)
    kinds = _kinds(model, "2.0").replace("@SOURCES@", "><SourceFiles>" + files + "</SourceFiles></{}>")
    exchange, simulation = kinds.split("\n")
    structure = [
        *listed("Outputs", model.of(STATE, RATE, OUTPUT)), *listed("Derivatives", model.of(RATE)),
        *listed("InitialUnknowns", model.of(RATE, OUTPUT)),
    ]  # fmt: skip
    return "\n".join([
        _head(model, "2.0", "guid") + ' numberOfEventIndicators="0">', exchange.format("ModelExchange"),
        simulation.format("CoSimulation"), _units(model), _experiment(model), "  <ModelVariables>", *lines,
        "  </ModelVariables>", "  <ModelStructure>", *structure, "  </ModelStructure>", "</fmiModelDescription>", "",
    ])  # fmt: skip


def _description_3(model: FmuModel, compiled: Sequence[str]) -> str:
    """Return the modelDescription.xml of FMI 3.0."""
    states, first = model.of(STATE), model.of(RATE)[:1]
    lines = ['    <Float64 name="time" valueReference="0" causality="independent" variability="continuous" unit="s"/>']
    for k, variable in enumerate(model.variables, 1):
        start = f' start="{variable.start!r}"' if variable.role in (INPUT, STATE) else ""
        rate = f' derivative="{states[k - first[0]]}"' if variable.role == RATE else ""
        lines.append(
            f'    <Float64 name={quoteattr(variable.name)} valueReference="{k}" {_traits(model, variable)} '
            f"description={quoteattr(variable.about)} unit={quoteattr(variable.unit)}{start}{rate}/>"
        )
    structure = [f'    <Output valueReference="{k}"/>' for k in model.of(STATE, RATE, OUTPUT)]
    structure += [f'    <ContinuousStateDerivative valueReference="{k}"/>' for k in model.of(RATE)]
    structure += [f'    <InitialUnknown valueReference="{k}"/>' for k in model.of(RATE, OUTPUT)]
    return "\n".join([
        _head(model, "3.0", "instantiationToken") + ">", _kinds(model, "3.0").replace("@SOURCES@", "/>"), _units(model),
        _experiment(model), "  <ModelVariables>", *lines, "  </ModelVariables>", "  <ModelStructure>", *structure,
        "  </ModelStructure>", "</fmiModelDescription>", "",
    ])  # fmt: skip


def _build_description(model: FmuModel, compiled: Sequence[str]) -> str:
    """Return the buildDescription.xml of FMI 3.0."""
    files = "\n".join(f'      <SourceFile name="{name}"/>' for name in compiled)
    return (
        '<?xml version="1.0" encoding="UTF-8"?>\n<fmiBuildDescription fmiVersion="3.0">\n'
        f'  <BuildConfiguration modelIdentifier="{model.name}">\n    <SourceFileSet language="C99">\n{files}\n'
        "    </SourceFileSet>\n  </BuildConfiguration>\n</fmiBuildDescription>\n"
    )
