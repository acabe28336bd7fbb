"""The working folder of a command: no module, program or setting is taken from there but what the command names.

A case may lie in a folder that came from a stranger, and Python and libraries look for some of theirs in the folder in
which they are begun: `python -m` for every module, Matplotlib for `matplotlibrc` (of which a line names a program that
films are made with), a search path with a dot in it for programs. The command line leaves all of it out. What stands in
the user's own folders (as ~/.config/matplotlib), or is named by variables of the environment, stays.

Only what every Python has loaded before is imported here: this comes first of all. `python -m` alone looks for a few of
its own modules before (`importlib`): in a stranger's folder the command is `vibrocap`, or `python -P -m vibrocap`.
"""

import os
import sys

LOOK_THERE = ("matplotlib", "numba")  # libraries that read a file of the working folder when they are imported
NAMED = ("MATPLOTLIBRC", "MPLCONFIGDIR")  # files of theirs that a user names, from the working folder perhaps


def leave_out_its_modules() -> None:
    """No modules from there for `python -m vibrocap`; unless the package itself stands there."""
    modules = {word.removeprefix("-m").partition(".")[0] for word in sys.orig_argv[1:]}
    if sys.argv[:1] != ["-m"] or "vibrocap" not in modules or sys.flags.safe_path or not sys.path:
        return
    if os.path.realpath(sys.path[0]) != os.path.dirname(os.path.dirname(os.path.realpath(__file__))):
        del sys.path[0]


def leave_out() -> None:
    """No programs and settings from there, and no modules for the processes that a command begins."""
    os.environ["PYTHONSAFEPATH"] = "1"
    os.environ["NODEFAULTCURRENTDIRECTORYINEXEPATH"] = "1"  # which Windows knows
    places = os.environ.get("PATH", os.defpath).split(os.pathsep)
    os.environ["PATH"] = os.pathsep.join(place for place in places if os.path.isabs(place))
    for name in NAMED:
        if os.environ.get(name):
            os.environ[name] = os.path.abspath(os.environ[name])
    if not any(isinstance(finder, _Elsewhere) for finder in sys.meta_path):
        sys.meta_path.insert(0, _Elsewhere())


class _Elsewhere:
    """Has libraries that look into the working folder imported in another; a finder, as `sys.meta_path` has them."""

    def find_spec(self, name, path=None, target=None):
        """How a module is found and made: as usual, but for some."""
        if name not in LOOK_THERE:
            return None
        for finder in sys.meta_path:
            spec = None if finder is self or not hasattr(finder, "find_spec") else finder.find_spec(name, path, target)
            if spec is not None:
                if spec.loader is not None:
                    spec.loader = _MadeElsewhere(spec.loader)  # type: ignore[assignment]
                return spec
        return None


class _MadeElsewhere:
    """A loader that makes its module while the working folder is the root, in which no stranger writes."""

    def __init__(self, loader):
        self._loader = loader

    def __getattr__(self, name):
        return getattr(self._loader, name)

    def create_module(self, spec):
        """As usual."""
        return self._loader.create_module(spec)

    def exec_module(self, module):
        """As usual, elsewhere."""
        try:
            here = os.getcwd()
        except OSError:  # it is gone
            self._loader.exec_module(module)
            return
        os.chdir(os.path.abspath(os.sep))
        try:
            self._loader.exec_module(module)
        finally:
            os.chdir(here)


leave_out_its_modules()
