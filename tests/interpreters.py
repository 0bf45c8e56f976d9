"""Fresh interpreters by the dozen, without starting each: one process is started, and a copy of it (``fork``) runs each text.

The process holds `LOADED` and nothing of dampyr, so a text finds what a fresh interpreter would, but for these. A start takes
0.3 s and more, a copy some milliseconds.
"""

import atexit
import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from functools import lru_cache
from pathlib import Path

LOADED = ("click", "json", "numpy", "tomllib", "traceback")
SERVER = """
import importlib, json, os, sys, traceback
for name in json.loads(sys.argv[1]):
    importlib.import_module(name)

def perform(text, argv, folder, environment, out, err):
    os.chdir(folder)
    os.environ.clear()
    os.environ.update(environment)
    for number, path in ((1, out), (2, err)):
        os.dup2(os.open(path, os.O_WRONLY), number)
    sys.argv[:] = argv
    sys.path[0:0] = [each for each in environment.get("PYTHONPATH", "").split(os.pathsep) if each]
    try:
        exec(compile(text, "<string>", "exec"), {"__name__": "__main__"})
    except SystemExit as end:
        code = 0 if end.code is None else end.code
        if not isinstance(code, int):
            print(code, file=sys.stderr)
            code = 1
    except BaseException:
        traceback.print_exc()
        code = 1
    else:
        code = 0
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code)

for line in sys.stdin:
    child = os.fork()
    if child == 0:
        null = os.open(os.devnull, os.O_RDONLY)
        os.dup2(null, 0)
        perform(**json.loads(line))
    print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), flush=True)
"""


@lru_cache(maxsize=8)
def _server(loaded: tuple[str, ...]) -> "subprocess.Popen[str]":
    command = [sys.executable, "-c", SERVER, json.dumps(loaded)]
    server = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    atexit.register(server.kill)
    return server


def run_text(
    text: str,
    argv: Sequence[str | Path] = ("-c",),
    folder: str | Path = ".",
    environment: Mapping[str, str] = os.environ,
    loaded: tuple[str, ...] = LOADED,
) -> "subprocess.CompletedProcess[str]":
    """Run a text of Python as ``python -c`` would, in a copy of a process that has loaded ``loaded`` alone."""
    if not hasattr(os, "fork"):
        command = [sys.executable, "-c", text, *map(str, argv[1:])]
        return subprocess.run(command, cwd=folder, env=dict(environment), capture_output=True, text=True, check=False)
    server = _server(loaded)
    assert server.stdin is not None
    assert server.stdout is not None
    with tempfile.TemporaryDirectory() as place:
        out, err = Path(place, "out"), Path(place, "err")
        out.touch()
        err.touch()
        request = {"text": text, "argv": list(map(str, argv)), "folder": str(Path(folder).absolute())}
        request |= {"environment": dict(environment), "out": str(out), "err": str(err)}
        server.stdin.write(json.dumps(request) + "\n")
        server.stdin.flush()
        code = int(server.stdout.readline())
        return subprocess.CompletedProcess([sys.executable, *map(str, argv)], code, out.read_text(), err.read_text())


def run_file(path: str | Path, *words: str | Path) -> "subprocess.CompletedProcess[str]":
    """Run a file of Python as ``python path words`` would."""
    beside = str(Path(path).parent)
    text = f"import runpy, sys\nsys.path.insert(0, {beside!r})\nrunpy.run_path({str(path)!r}, run_name='__main__')"
    return run_text(text, (path, *words))
