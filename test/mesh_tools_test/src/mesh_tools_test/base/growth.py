"""How times grow with the size of a mesh: as a table and as a plot."""
from pathlib import Path
from typing import Dict, List, NamedTuple

LEAST = 1e-6  # ms; what is measured as 0 is taken for that
_INCHES, _DOTS = (8.0, 5.0), 110


class Growth(NamedTuple):
    """Times of the same things on meshes of growing size.

    what: is counted (vertices or faces); counts: ascending, one for each mesh; times: of each mesh,
    name -> milliseconds
    """

    what: str
    counts: List[int]
    times: List[Dict[str, float]]

    def table(self) -> str:
        """Milliseconds, a column a size; the last column is the growth from first to last."""
        lines = ["%-24s" % "ms" + "".join("%13s" % f"{n:,}" for n in self.counts) + "    growth"]
        for name in self.times[0]:
            values = [column[name] for column in self.times]
            row = "".join("%13.4g" % value for value in values)
            lines.append("%-24s%s %8.1f x" % (name, row, values[-1] / max(values[0], LEAST)))
        growth = self.counts[-1] / self.counts[0]
        lines.append("%-24s%s %8.1f x" % (self.what, " " * 13 * len(self.counts), growth))
        return "\n".join(lines)

    def plot(self, path: Path) -> None:
        """Milliseconds over sizes, both logarithmic, as PNG; a gray line grows as the mesh does."""
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure

        figure = Figure(figsize=_INCHES, dpi=_DOTS, constrained_layout=True)
        FigureCanvasAgg(figure)
        axes = figure.add_subplot()
        for name, marker in zip(self.times[0], "osD^vP*Xhd" * len(self.times[0])):
            values = [max(column[name], LEAST) for column in self.times]
            axes.plot(self.counts, values, marker=marker, label=name)
        low = min(max(column[name], LEAST) for column in self.times[:1] for name in column)
        line = [low * count / self.counts[0] for count in self.counts]
        axes.plot(self.counts, line, color="gray", linestyle=":", label="in proportion")
        axes.set(xscale="log", yscale="log", xlabel=self.what, ylabel="ms")
        axes.grid(True, which="both", alpha=0.2)
        axes.legend(fontsize="small", loc="center left", bbox_to_anchor=(1.0, 0.5))
        figure.savefig(str(path))
