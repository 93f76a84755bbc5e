"""Where the report on the paper does its computations, each of them once.

What has been computed is kept in files named by what it depends on: the whole text of the case
after its changes, what is sought, and the format of results. A report that is made again, or was
interrupted, takes from them what it finds; without the folder ``kept`` it computes everything.
"""

import json
import shutil
from collections.abc import Callable, Iterable, Mapping, Sequence
from hashlib import sha256
from pathlib import Path
from time import perf_counter
from typing import Any, NamedTuple

import numpy as np

from coupling import casefile
from coupling.errors import BadCase, Problem
from coupling.overrides import override
from coupling.report_tables import Overrides, Sought
from coupling.reports.timed_runs import Ran, timed
from coupling.scene import Scene

CASES = Path(__file__).resolve().parents[2] / "cases"
Quantities = Mapping[str, str | Sought]


class Recorded(NamedTuple):
    """A run with everything that a user gets: its folder, exit code, reason, time it took [s]."""

    folder: Path
    code: int
    reason: str
    seconds: float

    def picture(self, name: str) -> Path:
        """A picture of the run, such as ``overview``."""
        return self.folder / "pictures" / f"{name}.png"


class Workshop:
    """Runs cases for the sections of the report.

    Parameters
    ----------
    folder : where pictures go; what is kept stands in ``kept`` within it
    cases : folder with the cases of the paper
    say : told what is being done
    large : whether what takes an hour is wanted too, such as whole deployments
    """

    def __init__(
        self,
        folder: Path,
        cases: Path = CASES,
        say: Callable[[str], None] = lambda _: None,
        large: bool = False,
    ) -> None:
        self.folder, self.cases, self.say, self.large = folder, cases, say, large
        self.kept = folder / "kept"

    def scene(
        self, case: str, variants: Sequence[str] = (), overrides: Overrides | None = None
    ) -> Scene:
        """A case of the paper with changes.

        Raises
        ------
        BadCase : it is not there, or the changes make it a faulty one
        """
        given = [override(path, value) for path, value in (overrides or {}).items()]
        return casefile.read(self.cases / case, [o.text for o in given], variants)

    def run(
        self,
        case: str,
        variants: Sequence[str] = (),
        overrides: Overrides | None = None,
        quantities: Quantities | None = None,
    ) -> Ran:
        """Quantities of a case over time; ``ran.wall[0]`` is how long it took [s].

        Parameters
        ----------
        quantities : name -> such as ``probe.tip.z``, or a whole [report.NAME.quantity.NAME]
        """
        scene = self.scene(case, variants, overrides)
        sought = {
            name: Sought(of=of) if isinstance(of, str) else of
            for name, of in (quantities or {}).items()
        }
        shape = json.dumps({name: s.model_dump() for name, s in sought.items()}, sort_keys=True)
        found = self.once(f"{case} {' '.join(variants)}", (scene.text, shape), lambda: (
            _of_ran(_watched(scene, sought))
        ))  # fmt: skip
        return _ran(found)

    def recorded(
        self, case: str, variants: Sequence[str] = (), overrides: Overrides | None = None
    ) -> Recorded:
        """A whole run with results.h5 and pictures, as ``thermobody run`` makes it."""
        scene = self.scene(case, variants, overrides)
        place = self.kept / "runs" / self._key(scene.text)

        def made() -> dict[str, Any]:
            from coupling import analyses, simulation
            from coupling.plot import plot

            shutil.rmtree(place, ignore_errors=True)
            begun = perf_counter()
            still = scene.analysis.kind != "dynamics"
            outcome = (
                analyses.run(scene, place, None) if still
                else simulation.run(scene, place, False, None)
            )  # fmt: skip
            seconds = perf_counter() - begun
            plot(outcome.folder / "results.h5")
            return {"folder": str(outcome.folder.relative_to(self.kept)), "code": outcome.code,
                    "reason": outcome.reason, "seconds": seconds}  # fmt: skip

        found = self.once(f"run {case} {' '.join(variants)}", (scene.text, "recorded"), made)
        return Recorded(**{**found, "folder": self.kept / found["folder"]})

    def sweep(self, case: str, name: str) -> Any:
        """The points of [sweep.NAME] of a case; see ``coupling.sweeps.run``."""
        from coupling import sweeps

        scene = self.scene(case)
        self.say(f"sweep {name} of {case}")
        return sweeps.run(scene, name, self.kept / "sweeps" / self._key(scene.text, name))

    def verified(self, name: str) -> list[Any]:
        """Results of a problem of ``thermobody verify``, by its name."""
        from coupling.verify.registry import problems

        for one in problems():
            if one.name == name:
                self.say(f"verify {one.area}: {name}")
                return list(one.solve())
        raise BadCase("verify", [Problem(name, "there is no such problem")])

    def checks(self, name: str) -> list[tuple[str, float, float, str]]:
        """Name, value, reference, unit of each number of a problem of ``thermobody verify``."""
        return self.once(f"verify {name}", ("checks", name), lambda: [
            (one.name, one.value, one.reference, one.unit)
            for one in self.verified(name) if hasattr(one, "value")
        ])  # fmt: skip

    def orders(self, name: str) -> list[tuple[str, float, float]]:
        """Name, observed order, that of theory of each convergence of such a problem."""
        return self.once(f"verify {name}", ("orders", name), lambda: [
            (one.name, one.order, one.theory)
            for one in self.verified(name) if hasattr(one, "order")
        ])  # fmt: skip

    def picture(self, source: Path, name: str) -> Path:
        """A copy of a picture in the folder of the report."""
        self.folder.mkdir(parents=True, exist_ok=True)
        return Path(shutil.copyfile(source, self.folder / f"{name}{source.suffix}"))

    def once(self, what: str, depends: Iterable[str], make: Callable[[], Any]) -> Any:
        """What ``make`` returns, as JSON holds it: made, or found from before."""
        file = self.kept / f"{self._key(*depends)}.json"
        if file.exists():
            return json.loads(file.read_text(encoding="utf-8"))
        self.say(what)
        found = make()
        file.parent.mkdir(parents=True, exist_ok=True)
        part = file.with_suffix(".part")
        part.write_text(json.dumps(found), encoding="utf-8")
        part.replace(file)
        return found

    def _key(self, *texts: str) -> str:
        return sha256("\0".join((_version(), *texts)).encode()).hexdigest()[:20]


def _version() -> str:
    from coupling.reading import FORMAT_VERSION

    return f"format {FORMAT_VERSION}"


def _watched(scene: Scene, sought: Mapping[str, Sought]) -> Ran:
    """A run; where contacts are watched its time is that of the watched run."""
    begun = perf_counter()
    ran = timed(scene, sought, repeat=0)
    return ran if ran.wall else ran._replace(wall=(perf_counter() - begun - ran.start,))


def _of_ran(ran: Ran) -> dict[str, Any]:
    plain = ran._asdict()
    plain["times"] = ran.times.tolist()
    plain["values"] = {name: rows.tolist() for name, rows in ran.values.items()}
    plain["counts"] = {name: int(n) for name, n in ran.counts.items()}
    return plain


def _ran(plain: Mapping[str, Any]) -> Ran:
    values = {name: np.array(rows) for name, rows in plain["values"].items()}
    spent = {name: tuple(plain[name]) for name in ("wall", "processor")}
    return Ran(**{**plain, **spent, "times": np.array(plain["times"]), "values": values})
