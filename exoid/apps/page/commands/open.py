"""`exoid open`: the workbench in the browser, served by this machine to itself."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from exoid.ground.extras import needing
from exoid.workbench.command_line.options import add_common, add_question, between, whole_number

GROUP = "answer"
HELP = """the workbench in the browser: compare, point at a suspect, add it, watch the error fall

exoid open run1.csv run2.csv --verify run3.csv
prints the address of the page, which only this machine can reach; without recordings it offers to drop some or to begin
with the demo. A folder that was saved from the page is opened again as it was."""

LAST_PORT = 65535


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    add_question(parser, required=False)
    port = between(0, LAST_PORT, number=whole_number)
    parser.add_argument("--port", metavar="N", type=port, default=0, help="port of the page (a free one)")
    parser.add_argument("--no-browser", action="store_true", help="only print the address")
    add_common(parser, out="keep the session and its report in DIR")


def run(args: argparse.Namespace) -> int:
    """Serve the page until Ctrl-C."""
    from exoid.ground.cache import cache_folder

    with needing("page", "pages in a browser"):
        import joblib  # noqa: F401 - the search runs in a process of its own
        import starlette  # noqa: F401
        import uvicorn  # noqa: F401
    from exoid.apps.page.serve import serve
    from exoid.apps.page.workspace import Workspace

    workspace = Workspace(cache_folder() / "mappings", args.seed, args.cutoff, args.derivative)
    try:
        if args.out:
            from exoid.apps.page.saved import free_for_session, keep_in

            keep_in(workspace, free_for_session(Path(args.out)))
        _open(workspace, args)
        serve(workspace, args.port, not args.no_browser, not args.quiet)
    except BaseException:
        workspace.keeping.release()  # nothing is kept of what could not be opened
        workspace.close()
        raise
    if args.json:
        from exoid.apps.page.views import state
        from exoid.workbench.command_line.files import write_json

        write_json(args.json, {"schema": "exoid.workspace/1", **state(workspace)})
    return 0


def _open(workspace: Any, args: argparse.Namespace) -> None:
    """Hand over what the command line names; what does not exist is refused here."""
    from exoid.apps.page.given import FIT, VERIFY
    from exoid.apps.page.saved import is_session, reopen
    from exoid.workbench.command_line.inputs import loaded_links, told_recordings
    from exoid.workbench.command_line.parser import UsageError

    if args.wearer:
        remedy = "write [wearer] with mass and height into a model file, and give it with --model"
        raise UsageError("the page takes a wearer from the model file", where="--wearer", remedy=remedy)
    if len(args.recordings) == 1 and is_session(args.recordings[0]):
        reopen(workspace, Path(args.recordings[0]))
        return
    if args.model:
        workspace.use_model(Path(args.model), args.model)
    given, unseen, told = told_recordings(args, workspace.model.joint_names)
    if links := loaded_links(args.payload, list(told)):
        remedy = f"`exoid discover` weighs it first; then give --payload {next(iter(links))}=KG@M"
        raise UsageError("the page takes loads with their mass and place", where="--payload", remedy=remedy)
    for files, role in ((given, FIT), (unseen, VERIFY)):
        for path in files.paths:
            among = path not in files.named
            workspace.add_file(Path(path), Path(path).name, role, told=told[path], among=among)
        for path, kind in files.others.items():
            workspace.leave_out(kind, Path(path).name)
