"""The page of `vibrocap lab` in Chromium: how soon the first motion is there, how long a slider's frame, a map.

`python -m benchmarks.lab`. Asked of two quiet cores: the first motion within 300 ms, a slider's frame in 20 ms (median)
and 50 ms (95th percentile) at 40 periods of both laws, a map of 64 x 64 settled motions within 4 s. The page itself
measures; a frame is from the slider's input until the panels are drawn. The load of the machine is said beside it.
"""

import contextlib
import gzip
import io
import os
import statistics
import sys
import tempfile
from pathlib import Path

from vibrocap.cli.main import main as vibrocap

sys.path.append(str(Path(__file__).resolve().parents[1] / "tests"))  # the browser, which the tests use too

OPENINGS, FRAMES = 7, 120
DRAG = """(async () => {
  const row = lab.controls.rows.get("machine.mass_ratio"), found = [];
  for (let k = 0; k < %d; k++) {
    lab.frames.length = 0;
    row.slider.value = String(300 + 2 * k);
    row.slider.dispatchEvent(new Event("input"));
    while (!lab.frames.length) await new Promise((resume) => setTimeout(resume, 0));
    found.push(lab.frames[0]);
    await new Promise((resume) => requestAnimationFrame(resume));
  }
  return found.slice(10);
})()"""


def main() -> None:
    """Print all of it."""
    from browser import CHROMIUM, browser

    if CHROMIUM is None:
        print("no chromium is installed")
        return
    with tempfile.TemporaryDirectory() as folder, browser() as page:
        out = Path(folder) / "lab.html"
        with contextlib.redirect_stdout(io.StringIO()):
            vibrocap(["lab", "--out", str(out)])
        text = out.read_bytes()
        print(f"page: {len(text) / 1e3:.0f} kB, {len(gzip.compress(text, 9)) / 1e3:.0f} kB gzipped")
        first = []
        for _ in range(OPENINGS):
            page.open(out.as_uri())
            page.wait("document.body.dataset.settled")
            first.append(page.js("lab.first"))
        print(f"first motion: {statistics.median(first):.0f} ms (best {min(first):.0f}) after opening")
        for law in ("exponential", "lugre"):
            page.open(f"{out.as_uri()}#v=1&preset=paper-5-8-{law}")
            page.wait("document.body.dataset.settled")
            frames = sorted(page.js(DRAG % FRAMES))
            median, late = statistics.median(frames), frames[int(0.95 * len(frames))]
            print(f"slider, {law}, 40 periods: {median:.1f} ms (median), {late:.1f} ms (95 %)")
        page.open(f"{out.as_uri()}#v=1&preset=paper-5-8-exponential")
        page.wait("document.body.dataset.settled")
        page.js("lab.mode('map')")
        took = float(page.wait("document.body.dataset.map", 300))
        print(
            f"map, 64 x 64, exponential: {took / 1e3:.1f} s with {page.js('lab.fields._pool.workers.length')} worker(s)"
        )
    print(f"load of the machine: {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores")


if __name__ == "__main__":
    main()
