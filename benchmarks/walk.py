"""What a reader of a run walks through: files and functions entered from a case file to the table of its events.

    python -m benchmarks.walk

Once with no kernel kept, so that the run writes and compiles its own, and once with the kernel found, each in a process
of its own. Functions within functions count as the functions that they stand in, bodies of classes do not count.
"""

import json
import os
import pathlib
import subprocess
import sys
import tempfile

from benchmarks.cold_start import CASE

WALKER = """
import inspect, json, sys, threading
entered = set()

def walk(frame, event, argument):
    code = frame.f_code
    if event == "call" and "vibrocap" in code.co_filename and code.co_flags & inspect.CO_OPTIMIZED:
        entered.add((code.co_filename, code.co_qualname.split(".<locals>")[0]))

threading.setprofile(walk)
sys.setprofile(walk)
import vibrocap
motion = vibrocap.simulate(vibrocap.read_case(sys.argv[1]))
table = motion.events
sys.setprofile(None)
loaded = [name for name in sys.modules if name.startswith("vibrocap.")]
print(json.dumps([len(loaded), len({file for file, _ in entered}), len(entered)]))
"""


def main() -> None:
    """Print how many files are loaded, and how many files and functions are entered."""
    print("\nFrom a case file to the table of events: files loaded, files and functions entered")
    with tempfile.TemporaryDirectory() as folder:
        case = pathlib.Path(folder, "case.toml")
        case.write_text(CASE.format(law="exponential", mass_ratio=2.5))
        for label in ("nothing kept", "second call"):
            command = [sys.executable, "-c", WALKER, str(case)]
            environment = os.environ | {"VIBROCAP_CACHE": str(pathlib.Path(folder, "kernels"))}
            done = subprocess.run(command, check=True, capture_output=True, text=True, env=environment)
            loaded, files, functions = json.loads(done.stdout)
            print(f"  {label:16s}{loaded:5d} loaded{files:5d} files{functions:6d} functions")


if __name__ == "__main__":
    main()
