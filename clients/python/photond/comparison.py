"""Comparisons: speed against error, method by method."""

from __future__ import annotations

from typing import Any, Callable, Dict, List, Optional, Union, cast

from ._daemon import Daemon
from ._files import Path
from ._text import TextTable, counted, human_bytes, human_error, human_number, human_seconds, row_name
from .bias import BiasMap
from .curves import Curve, MeanCurve, drawable, time_to_error
from .errors import PhotondError
from .job import Job
from .plots import plot_curves
from .progress import Progress, shown
from .work import JobGroup
from .shapes import Json, TableRow, WelchMap


class Comparison(JobGroup):
    """A set of jobs that run one at a time on a device, so that their clocks are fair. Printed, or shown in a notebook, it
    is its table.

    >>> comparison = client.compare("furnace", ["path_tracing", photond.entry("photon_mapping", "photons")], width=16,
    ...                             height=16, passes=4, reference="path_tracing:16", seeds=[1, 2])
    >>> comparison.state, len(comparison.jobs)
    ('succeeded', 4)
    >>> [row["label"] for row in comparison.table]
    ['path_tracing', 'photons']
    >>> curve = comparison.curves("relative_mse")[0]
    >>> curve.label, curve.seed, curve.passes[0], curve.passes[-1]
    ('path_tracing', 1, 1, 4)
    >>> [mean.name for mean in comparison.mean_curves()]
    ['path_tracing', 'photons']
    """

    kind = "comparisons"

    def __init__(self, client: Daemon, data: Json) -> None:
        super().__init__(client, data)
        self._report: Optional[Json] = None

    # --- what is known of it ------------------------------------------------------------------------------------------
    @property
    def metrics(self) -> List[str]:
        """Those of the tables; the first decides the Pareto front."""
        return list(self.request.get("metrics") or [])

    def _whole(self) -> Json:
        """One from a list comes without its jobs and its table."""
        if "table" not in self.data:
            self.refresh()
        return self.data

    @property
    def table(self) -> List[TableRow]:
        """Its rows as the daemon has them: error at the end, time to errors, error at times, memory, efficiency, and with
        two seeds or more `bias`: squared bias and variance apart."""
        return cast(List[TableRow], self._whole()["table"])

    @property
    def job_ids(self) -> List[str]:
        return [job["id"] for job in self._whole()["jobs"]]

    @property
    def jobs(self) -> List[Job]:
        """Asked of the daemon one by one."""
        return [Job.fetch(self._client, id) for id in self.job_ids]

    @property
    def title(self) -> Optional[str]:
        """What somebody calls it."""
        return cast(Optional[str], self.request.get("title"))

    @property
    def notes(self) -> Optional[str]:
        """What somebody notes of it, in lines."""
        return cast(Optional[str], self.request.get("notes"))

    @property
    def reference(self) -> Optional[Json]:
        """The jobs or the image all is measured against (`form`: two_films, film or image; `jobs`), its state, and its own
        noise (`error`)."""
        return cast(Optional[Json], self._whole()["reference"])

    @property
    def headlines(self) -> Dict[str, str]:
        """What the comparison comes to, a sentence for each metric that has one: who is first and where that changes."""
        return {headline["metric"]: headline["text"] for headline in self._whole()["headlines"]}

    @property
    def warnings(self) -> List[str]:
        """Which jobs lost processor time to other processes, and what became of that: the daemon repeats such a job twice at
        most, `Job.repeat` once more. Verdicts that could rest on it are too close to call."""
        return cast(List[str], self._whole()["warnings"])

    @property
    def marks(self) -> Dict[str, str]:
        """By the names of the rows that have light which the reference lacks: what that is. It counts as their error."""
        return {row_name(row["label"], row["parameters"]): cast(str, row["mark"]) for row in self.table if row.get("mark")}

    @property
    def verdicts(self) -> List[str]:
        """Who reaches which error first, as sentences, for each metric by falling error."""
        return [verdict["text"] for verdict in self._whole().get("verdicts") or []]

    # --- following and changing it --------------------------------------------------------------------------------------
    def wait(self, timeout: Optional[float] = None, *, check: bool = True, cancel_on_interrupt: bool = False,
             on_change: Optional[Callable[["Comparison"], object]] = None,
             progress: "Progress[Comparison]" = None) -> "Comparison":
        """Until all its jobs are over. Raises TimedOut after `timeout` seconds (it goes on), and with `check`
        ComparisonFailed where not all succeeded. `progress` as for a job's."""
        self._follow(timeout, cancel_on_interrupt, on_change, shown(progress))
        if check and self.state != "succeeded":
            raise ComparisonFailed(self, self._failure_text())
        return self

    def _failure_text(self) -> str:
        lines = [f"comparison {self.id} {'was cancelled' if self.state == 'cancelled' else 'failed'}"]
        for row in self._whole()["jobs"]:
            if row["state"] == "failed":
                problem = Job.fetch(self._client, row["id"]).failure or {}
                lines.append(f"  {row_name(row['label'], row['parameters'])}, seed {row['seed']} ({row['id']}): "
                             f"{problem.get('detail') or 'failed'}")
        return "\n".join(lines)

    # --- curves -------------------------------------------------------------------------------------------------------
    def report(self) -> Json:
        """`report.json`: the comparison and every curve, so far or final."""
        if self._report is None or not self.is_over:
            self._report = self._client.get(self._path("/report.json"))
        return self._report

    def _metric(self, metric: Optional[str]) -> str:
        if metric is not None:
            return metric
        if not self.metrics:
            raise ValueError("which metric? the comparison has none of its own")
        return self.metrics[0]

    def curves(self, metric: Optional[str] = None) -> List[Curve]:
        """Error over time of every job; default: by the first of its metrics."""
        metric = self._metric(metric)
        report = self.report()
        points_of: Dict[str, List[Json]] = {curve["job"]: curve["points"] for curve in report["curves"]}
        curves = []
        for job in report["jobs"]:
            shown = drawable([(point, (point["metrics"] or {}).get(metric), (point.get("intervals") or {}).get(metric))
                              for point in points_of.get(job["id"], [])])
            points = shown.points
            curves.append(Curve(job["label"], job["parameters"], job["seed"], job["id"],
                                [point["seconds"] for point in points], [point["passes"] for point in points],
                                [point["metrics"][metric] for point in points], shown.intervals, shown.bounds))
        return curves

    def mean_curves(self, metric: Optional[str] = None) -> List[MeanCurve]:
        """One for each row, over its seeds, as the daemon's reports have them; rows with no point are left out."""
        metric = self._metric(metric)
        means = []
        for row in self.report()["table"]:
            shown = drawable([(point, point["error"], point.get("interval"))
                              for point in row["mean_curve"].get(metric) or []])
            points = shown.points
            if not points and not shown.bounds:
                continue
            spread = bool(points) and all(point["low"] is not None for point in points)
            means.append(MeanCurve(row["label"], row["parameters"], [point["seconds"] for point in points],
                                   [point["error"] for point in points],
                                   [point["low"] for point in points] if spread else None,
                                   [point["high"] for point in points] if spread else None,
                                   shown.intervals, shown.bounds))
        return means

    def floors(self, metric: Optional[str] = None) -> Dict[str, float]:
        """By a row's name, what its error comes to at least, whatever its passes (at 90 %): of rows of fixed parameters
        whose bias is told apart from 0."""
        metric = self._metric(metric)
        is_root = metric.rpartition(":")[2] == "rmse"  # bias and variance are told apart of the mean of squares
        floors = {}
        for row in self.table:
            bias = (row.get("bias") or {}).get(metric[:-len("rmse")] + "mse" if is_root else metric)
            if bias and bias["floor"] and bias["low"] > 0:
                floors[row_name(row["label"], row["parameters"])] = bias["low"] ** 0.5 if is_root else bias["low"]
        return floors

    def bias_map(self, row: Union[int, str], layer: str = "beauty") -> BiasMap:
        """Where a row's mean is not the reference, as values and a picture. `row`: its number in `table` or its name; of two
        seeds or more, against two films, when the comparison is over (else raises Refused)."""
        if isinstance(row, str):
            names = [row_name(one["label"], one["parameters"]) for one in self.table]
            if row not in names:
                raise ValueError(f"there is no row {row!r}: {', '.join(names)}")
            row = names.index(row)
        data = cast(WelchMap, self._client.get(self._path(f"/rows/{row}/bias.json"), {"layer": layer}))
        return BiasMap(data, self.download(f"rows/{row}/bias.png", layer=layer))

    def plot(self, metric: Optional[str] = None, *, ax: Any = None) -> Any:
        """Error over time on log axes, by matplotlib, with bands: 95 % over the seeds, or of one seed what the reference's
        noise leaves open. Arrows are upper bounds, dotted lines `floors`. Returns its Axes."""
        metric = self._metric(metric)
        curves = self.mean_curves(metric)
        known = any(curve.bounds or any(curve.intervals) for curve in curves)  # then that noise has no part in the errors
        noise = None if known else ((self.reference or {}).get("error") or {}).get(metric)
        return plot_curves(curves, metric, ax=ax, reference_noise=noise, floors=self.floors(metric))

    # --- tables -------------------------------------------------------------------------------------------------------
    def rows(self, metric: Optional[str] = None) -> List[Json]:
        """The table by one metric: a dictionary a row, fit for `pandas.json_normalize`. `low` and `high` are of 95 % over the
        seeds; `least` and `greatest` what the reference's noise leaves open, at 90 %; `bias` the row's own."""
        metric = self._metric(metric)
        rows: List[Json] = []
        for row in self.table:
            end: Any = row["error"].get(metric) or {}
            least, greatest = end.get("interval") or (None, None)
            rows.append({
                "name": row_name(row["label"], row["parameters"]), "label": row["label"], "parameters": row["parameters"],
                "seeds": row["seeds"], "passes": (row["passes"] or {}).get("min"),
                "seconds": (row["seconds"] or {}).get("max"), "error": end.get("value"), "low": end.get("low"),
                "high": end.get("high"), "least": least, "greatest": greatest, "reference_noise": end.get("reference"),
                "near_reference": end.get("near_reference"), "peak_bytes": row["peak_bytes"],
                "efficiency": row["efficiency"], "pareto": row["pareto"],
                "bias": (row.get("bias") or {}).get(metric)})
        return rows

    def time_to_error(self, error: float, metric: Optional[str] = None) -> Dict[str, Optional[float]]:
        """Seconds until each row's mean curve comes to `error` (`curves.time_to_error`); None where it does not."""
        return {mean.name: time_to_error(mean, error) for mean in self.mean_curves(metric)}

    def _text_table(self, metric: str) -> TextTable:
        table = TextTable(["", ">passes", ">time", f">{metric}", ">peak memory", ""])
        for row in self.rows(metric):
            interval = None if row["least"] is None else [row["least"], row["greatest"]]
            if (row["error"] or 0) > 0 and row["low"] is not None:
                error = f"{human_number(row['error'])} ({human_number(row['low'])} to {human_number(row['high'])})"
            else:
                error = human_error(row["error"], interval)
            near = "near the reference's noise" if interval is None else "not known to a third of itself"
            remarks = ["Pareto"] * bool(row["pareto"]) + [near] * bool(row["near_reference"])
            table.add([row["name"], human_number(row["passes"]), human_seconds(row["seconds"]), error,
                       human_bytes(row["peak_bytes"]), ", ".join(remarks)])
        return table

    def table_text(self, metric: Optional[str] = None) -> str:
        return str(self._text_table(self._metric(metric)))

    def save_report(self, path: Path) -> None:
        """The daemon's own report, by what the path ends with: .html (one page that stands alone), .csv (every point of
        every curve) or .json."""
        suffix = str(path).rpartition(".")[2].lower()
        if suffix not in ("html", "csv", "json"):
            raise ValueError(f"cannot tell what to save as {path}: name it .html, .csv or .json")
        self.download(f"report.{suffix}", path)

    def _warning_texts(self) -> List[str]:
        return [f"{text}." for text in self.warnings] + [f"{name}: {text}." for name, text in self.marks.items()]

    def _headline_texts(self) -> List[str]:
        return [f"By {metric}: {text}." for metric, text in self.headlines.items()]

    def __str__(self) -> str:
        if not self.metrics:
            return repr(self)
        return "\n".join([repr(self), self.table_text(), *self._warning_texts(), *self._headline_texts(), *self.verdicts])

    def __repr__(self) -> str:
        image = self.request["image"]
        named = f" \"{self.title}\"" if self.title else ""
        return (f"<Comparison {self.id}{named} {self.state}: {self.request['scene']}, {image['width']} x {image['height']}, "
                f"{counted(len(self.request['entries']), 'entry', 'entries')}>")

    def _repr_html_(self) -> Optional[str]:
        if not self.metrics:
            return None
        return self._text_table(self._metric(None)).html(" ".join(
            [f"{repr(self)[1:-1]}.", *self._warning_texts(), *self._headline_texts()]))


class ComparisonFailed(PhotondError):
    """`comparison` ended with failed or cancelled jobs; the others' results are there."""

    def __init__(self, comparison: Comparison, message: str) -> None:
        self.comparison = comparison
        super().__init__(message)
