"""What is drawn for run k: by seed, k and path alone, by the right law, the same for ever."""

from __future__ import annotations

import itertools
import tracemalloc
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy import stats

from flexdyn.batch.draws import draws_of_run, uniform_draws
from flexdyn.batch.study import Study
from flexdyn.batch.studyfile import read_study
from tests.batch.studies import STUDY, write_study


@pytest.fixture(scope="module")
def study(tmp_path_factory: pytest.TempPathFactory) -> Study:
    """A study of random numbers."""
    return read_study(write_study(tmp_path_factory.mktemp("study"), runs=4000))


LAWS = {
    "joints.shoulder.stiffness": stats.uniform(20, 40),
    "joints.elbow.rotor_inertia": stats.lognorm(0.1, scale=1e-5),
    "effects[1].level": stats.norm(0.05, 0.01),
}


@pytest.mark.parametrize("path", LAWS)
def test_draws_follow_their_law(study: Study, path: str) -> None:
    """4000 draws pass Kolmogorov and Smirnov's test against scipy's distribution of the same name."""
    values = [draws_of_run(study, k)[path] for k in range(study.count)]
    assert stats.kstest(values, LAWS[path].cdf).pvalue > 1e-3


def test_draws_are_independent(study: Study) -> None:
    """Neither another path, nor the run before, nor the next seed says anything about a draw (5 sigma)."""
    first, second = list(LAWS)[:2]
    runs = range(study.count)
    a = uniform_draws(7, first, runs)
    others = [uniform_draws(7, second, runs), uniform_draws(8, first, runs), np.roll(a, 1)]
    for other in others:
        assert abs(np.corrcoef(a, other)[0, 1]) < 5 / np.sqrt(study.count)
    assert len(set(a.tolist())) == study.count
    assert 0.0 < a.min() < a.max() < 1.0


def test_a_draw_does_not_know_of_other_paths_or_their_order(study: Study) -> None:
    """Leaving paths out or turning their order round changes no number of those that stay."""
    turned = replace(study, vary=dict(reversed(list(study.vary.items()))))
    alone = replace(study, vary={"effects[1].level": study.vary["effects[1].level"]})
    for k in (0, 1, 3999):
        assert draws_of_run(turned, k) == draws_of_run(study, k)
        assert draws_of_run(alone, k)["effects[1].level"] == draws_of_run(study, k)["effects[1].level"]


def test_draws_stay_what_they_are() -> None:
    """A store begun by one version can be gone on with by the next: the generator's numbers are fixed."""
    expected = [0.669081968085305, 0.9785291017731602, 0.030158446591853516]
    assert uniform_draws(7, "joints.shoulder.stiffness", (0, 1, 10**12)).tolist() == expected


def test_a_grid_is_the_cartesian_product(tmp_path: Path) -> None:
    """The last path changes fastest; no number of runs is given."""
    vary = {"effects[1].level": {"grid": [0.1, 0.2, 0.3]}, "command.scale": {"grid": [1, -1]}}
    study = read_study(write_study(tmp_path, vary=vary, runs=None))
    found = [tuple(draws_of_run(study, k).values()) for k in range(study.count)]
    assert found == list(itertools.product([0.1, 0.2, 0.3], [1.0, -1.0]))


def test_every_point_of_a_grid_has_its_own_draws(tmp_path: Path) -> None:
    """Random numbers beside a grid: ``runs`` draws at each of its points, all of them different."""
    vary = {**STUDY["vary"], "command.scale": {"grid": [0.5, 1.0, 2.0]}}
    study = read_study(write_study(tmp_path, vary=vary, runs=5))
    assert study.count == 15
    found = [draws_of_run(study, k) for k in range(15)]
    assert [each["command.scale"] for each in found] == [0.5] * 5 + [1.0] * 5 + [2.0] * 5
    assert len({each["effects[1].level"] for each in found}) == 15


def test_the_number_of_runs_costs_no_memory(study: Study) -> None:
    """Planning a hundred million runs and drawing the last of them takes less than 100 kB."""
    large = replace(study, runs=100_000_000)
    tracemalloc.start()
    last = draws_of_run(large, large.count - 1)
    bounds = large.bounds(large.chunks - 1)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert set(last) == set(study.vary)
    assert bounds.stop == large.count
    assert peak < 100_000
