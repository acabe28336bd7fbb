"""Draws drive-shapes.png, the picture of docs/design.md, from the table that `benchmarks/drive_shapes.py` makes.

python docs/images/drive-shapes.py
"""

import csv
from pathlib import Path

from vibrocap.plotting.look.finishing import save
from vibrocap.plotting.look.style import BLUE, ORANGE, VERMILION, figure, style

SERIES = (  # law, column, line, colour, label
    ("exponential", "speed", "o-", BLUE, "exponential law (EM)"),
    ("LuGre", "speed", "s--", ORANGE, "LuGre law (LM)"),
    ("tanh", "speed", "^:", VERMILION, "friction smoothed by tanh(v/0.01): what it claims"),
    ("tanh", "exact_speed", "v-", VERMILION, "the same designs under the exact law (0: lifts off)"),
)

if __name__ == "__main__":
    path = Path(__file__).with_suffix(".csv")
    rows = list(csv.DictReader(path.read_text(encoding="utf-8").splitlines()))
    with style():
        fig, axes = figure(1, 2, size=(7.4, 4.0))
        for ax, load in zip(axes[0], ("constant load", "dynamic load"), strict=True):
            for law, column, line, colour, label in SERIES:
                own = [row for row in rows if (row["load"], row["law"]) == (load, law)]
                places, speeds = [int(row["harmonics"]) for row in own], [float(row[column]) for row in own]
                ax.plot(places, speeds, line, color=colour, label=label, markersize=5, clip_on=False)
            ax.set(title=load, xlabel="harmonics of the drive", xticks=(1, 2, 3, 5), ylim=(0.0, 0.9))
        axes[0, 0].set_ylabel("mean velocity of the best design")
        fig.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=2)
        save(fig, Path(__file__).with_suffix(".png"))
