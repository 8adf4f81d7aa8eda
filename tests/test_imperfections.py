"""The worst and the likely imperfections, against closed forms, random ones and whole paths."""

import csv
import json
from functools import cache, partial
from math import atan, log, sin

import numpy as np
import pytest
from helpers import on_two_processes
from scipy.stats import chi2, norm
from typer.testing import CliRunner

import sheetfx as fx
from sheetfx.cli import app
from sheetfx.critical.amplitude_equations import AmplitudeEquations
from sheetfx.scenes import load_case
from sheetfx.studies.imperfections import path_of, perfect

SIZE = 0.05
SWAYS = [lambda x: np.outer(x[:, 2], (1.0, 0.0, 0.0)), lambda x: np.outer(x[:, 2], (0.0, 1.0, 0.0))]


def propped_bar(ratio: float) -> fx.Scene:
    """A stiff upright bar of length 1 on a hinge, held at its top by horizontal springs of stiffness 1 and `ratio`."""
    mesh = fx.read(lambda: fx.meshes.frame({"foot": (0.0, 0.0, 0.0), "top": (0.0, 0.0, 1.0)},
                                           {"bar": ("foot", "top", 1)}), 3)
    bar = fx.Bar(mesh, fx.Rectangle(1.0, 1.0), fx.Elastic(1e7))
    return fx.Scene([bar], [fx.pin(mesh, "foot")], [fx.PointForce(mesh, "top", (0.0, 0.0, -1.0))],
                    fx.Monitor(mesh, "top", "z"),
                    joints=[fx.Spring(mesh, "top", "x", 1.0), fx.Spring(mesh, "top", "y", ratio)])


def law(size: float) -> float:
    """Limit load with the top moved by a size: L (1 - sin(tilt)^(2/3))^(3/2) (after Augusti 1961)."""
    return (1 + size**2) ** 0.5 * (1 - sin(atan(size)) ** (2 / 3)) ** 1.5


@cache
def bars(ratio: float) -> fx.Imperfections:
    return fx.Imperfections(propped_bar(ratio), SWAYS,
                            lambda scene: fx.Path(scene, fx.ArcLength(0.2), fx.Until(deflection=0.9)))


@pytest.mark.slow
def test_worst_shape_is_along_the_softer_spring():
    first, second = bars(1.2).worst(SIZE, starts=2)
    for one in (first, second):
        assert one.load == pytest.approx(law(SIZE), rel=1e-4)
        assert abs(one.coefficients[0]) == pytest.approx(SIZE, rel=1e-3)
        assert np.linalg.norm(one.coefficients) == pytest.approx(SIZE, rel=1e-12)
    assert first.coefficients[0] * second.coefficients[0] < 0


@pytest.mark.slow
def test_gradient_is_that_of_differences_of_paths():
    place, step = np.array([0.04, 0.03]), 1e-4
    found = bars(1.2).gradient(place)
    differences = [(bars(1.2).at(place + step * way).load - bars(1.2).at(place - step * way).load) / (2 * step)
                   for way in np.eye(2)]
    assert found == pytest.approx(differences, rel=1e-4)


@pytest.mark.slow
def test_quantile_of_a_load_that_goes_with_the_size_alone():
    """The sizes of two independent normal coefficients have a distribution of Rayleigh."""
    probability = 0.05
    exact = law(SIZE * (-2 * log(probability)) ** 0.5)
    found = bars(1.0).quantile(probability, SIZE, samples=12)
    low, high = found.interval
    assert low <= exact <= high
    assert low <= found.load <= high
    assert high - low < 0.2 * exact


class Law(fx.LoadsByShape):
    """Loads that a function of the coefficients gives."""

    def __init__(self, count: int, load):
        self.count, self._load = count, load

    def at(self, coefficients):
        return fx.ImperfectLoad(tuple(coefficients), self._load(np.asarray(coefficients)), "limit")

    def gradient(self, coefficients):
        steps = 1e-6 * np.eye(self.count)
        return np.array([(self._load(coefficients + s) - self._load(coefficients - s)) / 2e-6 for s in steps])


@pytest.mark.parametrize(("count", "load", "exact"), [
    pytest.param(2, np.linalg.norm, chi2.isf(0.05, 2) ** 0.5, marks=pytest.mark.slow),
    pytest.param(4, np.linalg.norm, chi2.isf(0.05, 4) ** 0.5, marks=pytest.mark.slow),
    pytest.param(2, lambda c: abs(c[0]), norm.isf(0.025), marks=pytest.mark.slow), (3, lambda c: c[0], norm.isf(0.05)),
], ids=["circle", "ball", "two-sided", "one-sided"])
@pytest.mark.slow
def test_intervals_have_the_quantile_as_often_as_they_say(count, load, exact):
    """They are of 95 %; where the load is known exactly 2e-4 are left, by the places at which the mean is known."""
    law_of = Law(count, lambda c: 1.0 - float(load(c)))
    found = [law_of.quantile(0.05, 1.0, samples=20, seed=seed) for seed in range(8)]
    assert sum(q.interval[0] - 1e-3 <= 1 - exact <= q.interval[1] + 1e-3 for q in found) >= 6
    assert np.mean([q.load for q in found]) == pytest.approx(1 - exact, abs=0.05)
    assert np.std([q.load for q in found]) < 0.07  # 400 random ones: 0.07 to 0.14


def test_minima_of_a_law_are_found():
    """A load with three valleys, between which a full step to the fixed point goes to and fro."""
    ways = np.array([(0.8, 0.6, 0.0), (0.0, -0.6, 0.8), (-1.0, 0.0, 0.0)])

    def load(c):
        size = np.linalg.norm(c)
        return 1.0 - size * max(factor * np.exp(-((np.asarray(c) / size - way) ** 2).sum())
                                for way, factor in zip(ways, (0.5, 0.7, 0.4), strict=True))

    found = Law(3, load).worst(1.0)
    assert [one.load for one in found] == pytest.approx([0.3, 0.5, 0.6], abs=1e-6)


def test_a_valley_with_a_kink_is_followed():
    """Across it the slope is five times that along it, and leads from one side to the other."""
    found = Law(3, lambda c: 2.0 - c[1] + 5.0 * abs(c[0])).worst(1.0)
    assert found[0].load == pytest.approx(1.0, abs=0.1)


@pytest.mark.slow
def test_loads_that_are_known_are_not_looked_for_again():
    known, told = [bars(1.2).at((SIZE, 0.0))], []
    again = fx.Imperfections(propped_bar(1.2), SWAYS, fx.Path, known=known, told=told.append)
    assert again.at(known[0].coefficients) is known[0] and not told


@pytest.mark.parametrize(("call", "said"), [
    (lambda: fx.Imperfections(propped_bar(1.2), [], fx.Path), "no shapes"),
    (lambda: bars(1.2).at((0.1,)), "1 coefficients for 2 shapes"),
    (lambda: bars(1.2).worst(0.0), "size"),
    (lambda: bars(1.2).quantile(0.5, SIZE), "probability"),
])
def test_wrong_input_is_named(call, said):
    with pytest.raises(ValueError, match=said):
        call()


def test_a_path_without_a_critical_point_is_told():
    few = fx.Imperfections(propped_bar(1.2), SWAYS, lambda scene: fx.Path(scene, fx.ArcLength(), fx.Until(steps=1)))
    assert few.at((SIZE, 0.0)).kind == "none" and few.at((SIZE, 0.0)).load == np.inf
    with pytest.raises(ValueError, match="no critical point up to load"):
        few.gradient((SIZE, 0.0))
    with pytest.raises(ValueError, match="none of 8 imperfections of size 0.05 has a critical point"):
        few.worst(SIZE)


@pytest.mark.slow
def test_yielding_arch():
    """Gradients against differences, and the worst of one size against all around the circle."""
    case = load_case("arch")(full=True, no_punch=True, elements=12, yield_stress=60.0, hardening=500.0, to=8.0)
    _, ideal = perfect("arch", case, 2)
    loads = fx.Imperfections(case.scene, ideal.modes, lambda scene: fx.Path(
        scene, fx.ArcLength(step=0.0025, largest=2.0), fx.Until(deflection=9.0)))
    place, step = np.array([0.2, 0.1]), 1e-3
    differences = [(loads.at(place + way).load - loads.at(place - way).load) / (2 * step) for way in step * np.eye(2)]
    assert loads.gradient(place) == pytest.approx(np.array(differences), rel=1e-4)
    around = [(0.3 * np.cos(a), 0.3 * np.sin(a)) for a in np.linspace(0, 2 * np.pi, 12, endpoint=False)]
    worst = loads.worst(0.3, starts=1)[0].load
    assert worst <= min(loads.at(one).load for one in around) < 0.98 * ideal.load


@pytest.mark.slow
def test_friction_between_parts_is_refused_before_paths():
    with pytest.raises(ValueError, match="imperfections of double-plate: parts that touch each other rub"):
        perfect("double-plate", load_case("double-plate")(), 2)


def test_soft_modes_of_one_eigenvalue_are_not_parted():
    case = load_case("star-dome")()
    _, one = perfect("star-dome", case, 1)
    _, some = perfect("star-dome", case, 2)
    assert one.kind == some.kind
    assert len(one.modes) == 1
    assert len(some.modes) == 3


def test_components_of_a_field_make_its_covariance():
    mesh = fx.read(lambda: fx.meshes.rectangle((20, 10)), 3)
    components = fx.field_components([mesh], 0.7, 60)
    x = np.random.default_rng(0).uniform(0.1, 0.9, (20, 3)) * (1.0, 1.0, 0.0)
    values = np.array([component(x) for component in components])
    distances = np.linalg.norm(x[:, None] - x, axis=2)
    assert values.T @ values == pytest.approx(np.exp(-(distances / 0.7) ** 2), abs=1e-3)
    assert sum(component.variance for component in components) == pytest.approx(1.0, abs=1e-6)
    with pytest.raises(ValueError, match="tell 200 apart|tell .* apart; give a smaller count"):
        fx.field_components([mesh], 100.0, 60)


def equations(count: int, cubic: float = 0.0, quartic: float = 0.0) -> AmplitudeEquations:
    """Modes that are alike, with the energy quartic |a|^4 / 24 and, of one mode, cubic a^3 / 6."""
    one = np.eye(count)
    alike = sum(np.einsum(order, one, one) for order in ("ij,kl->ijkl", "ik,jl->ijkl", "il,jk->ijkl")) / 3
    nothing = np.zeros((count, count))
    return AmplitudeEquations(1.0, nothing, np.zeros(count), -one, np.full((count,) * 3, cubic), quartic * alike, -one,
                              nothing, np.zeros((count,) * 3))


@pytest.mark.parametrize("size", [1e-6, 1e-3, 0.05])
def test_ends_of_amplitude_equations_are_those_of_koiter(size):
    """Limits of m a - |A| a^2 / 2 = size and of m a - |C| a^3 / 6 = size, by m, the distance from the critical load."""
    end = equations(1, cubic=-3.0).end(np.array([size]))
    assert -end.change == pytest.approx((2 * 3.0 * size) ** 0.5, abs=3e-8)
    exact = (1.5 * size * (5.0 / 2) ** 0.5) ** (2 / 3)
    assert -equations(1, quartic=-5.0).end(np.array([size])).change == pytest.approx(exact, abs=3e-8)
    turned = equations(3, quartic=-5.0).end(size * np.array([0.6, 0.0, -0.8]))
    assert -turned.change == pytest.approx(exact, abs=3e-8)
    assert abs(turned.null @ (0.6, 0.0, -0.8)) == pytest.approx(1.0, rel=1e-6)


def test_an_imperfection_that_stabilises_has_no_end():
    assert equations(1, cubic=-3.0).end(np.array([-0.01])) is None
    assert equations(1, quartic=5.0).end(np.array([0.01])) is None


@cache
def energy_of(name: str, count: int, size: float) -> tuple[fx.ReducedEnergy, fx.Imperfections]:
    case = load_case(name)()
    record, ideal = perfect(name, case, count)
    paths = fx.Imperfections(case.scene, ideal.modes, partial(path_of, case))
    state = record.state_at(record.states[-1].critical[0])
    return fx.ReducedEnergy(record.path, state, ideal.modes, paths.scene, len(ideal.modes), size), paths


@pytest.mark.parametrize(("name", "count", "size", "error"), [
    ("star-dome", 2, 0.05, 1e-3), ("sinusoidal-arch", 3, 5e-4, 2e-3), ("sinusoidal-arch", 3, 2e-3, 3e-2)])
@pytest.mark.slow(quick=1)
def test_reduced_energy_tells_its_error(name, count, size, error):
    energy, paths = energy_of(name, count, 1e-5)
    way = np.random.default_rng(1).standard_normal(paths.count)
    c = size * way / np.linalg.norm(way)
    right, found = paths.at(c).load, energy.at(c).load
    assert found == pytest.approx(right, rel=error)
    assert energy.error(c) == pytest.approx(found - right, rel=0.1, abs=1e-7 * right)


def test_gradient_of_the_reduced_energy():
    energy, _ = energy_of("sinusoidal-arch", 3, 1e-5)
    c, step = np.array([1e-3, -5e-4, 7e-4]), 1e-6
    found = [(energy.at(c + step * way).load - energy.at(c - step * way).load) / (2 * step) for way in np.eye(3)]
    assert energy.gradient(c) == pytest.approx(found, rel=1e-2)


def test_reduced_energy_refuses_what_has_none():
    case = load_case("arch")()
    record, ideal = perfect("arch", case, 1)
    with pytest.raises(ValueError, match="no value of an energy alone"):
        fx.ReducedEnergy(record.path, record.states[-1], ideal.modes, lambda c: case.scene, 1, 1e-3)


ROORDA = ["imperfections", "roorda-frame", "--amplitude", "1e-3", "--shapes", "1", "--samples", "3"]


def results(folder) -> dict:
    return json.loads((folder / "imperfections.json").read_text())


def test_command_writes_the_worst_shape_and_goes_on_where_it_was(tmp_path):
    done = CliRunner().invoke(app, [*ROORDA, "-o", str(tmp_path)])
    assert done.exit_code == 0, done.output
    found, case = results(tmp_path), load_case("roorda-frame")()
    assert found["worst"]["load"] < found["perfect"]
    assert np.linalg.norm(found["worst"]["shape"]) == pytest.approx(1e-3)
    assert found["quantiles"].keys() == {"0.05"}
    assert (tmp_path / "worst.png").exists() and (tmp_path / "imperfections.png").exists()
    x, moved = np.split(np.loadtxt(tmp_path / "worst.csv", delimiter=",", skiprows=1), 2, axis=1)
    again = fx.imperfect(case.scene, fx.measured(x[:, :2], moved[:, :2]))
    states, path = [], path_of(case, again)
    for state in path:
        states.append(state)
        if state.critical:
            break
    assert states[-1].critical[0].load == pytest.approx(found["worst"]["load"], rel=1e-5)
    with (tmp_path / "loads.csv").open() as stream:
        rows = list(csv.reader(stream))
    assert len(rows) - 1 == found["paths"]
    (tmp_path / "loads.csv").write_text("\n".join(",".join(row) for row in rows[:4]) + "\n")
    resumed = CliRunner().invoke(app, [*ROORDA, "-o", str(tmp_path), "--resume"])
    assert resumed.exit_code == 0, resumed.output
    assert resumed.output.count(" at load ") == found["paths"] - 3 + 2
    assert results(tmp_path)["worst"]["load"] == pytest.approx(found["worst"]["load"], rel=1e-8)


@pytest.mark.slow
def test_reduced_energy_saves_paths(tmp_path):
    options = ["--amplitude", "0.05", "--shapes", "2", "--samples", "0", "-o", str(tmp_path)]
    done = CliRunner().invoke(app, ["imperfections", "star-dome", *options, "--reduced", "20"])
    assert done.exit_code == 0, done.output
    found = results(tmp_path)
    assert found["paths"] <= 2
    assert found["reduced"]["in_range"]
    told = found["reduced"]["worst"]["load"] - found["reduced"]["error"]
    assert told == pytest.approx(found["worst"]["load"], rel=1e-4)
    assert found["reduced"]["quantiles"].keys() == {"0.05"}


@pytest.mark.slow
def test_command_on_two_processes(tmp_path):
    arguments = [*ROORDA[:-1], "0", "--starts", "1"]
    assert CliRunner().invoke(app, [*arguments, "-o", str(tmp_path / "one")]).exit_code == 0
    two = [*arguments, "-o", str(tmp_path / "two")]
    on_two_processes(f"from sheetfx.cli import app\napp({two!r}, standalone_mode=False)")
    one, two = results(tmp_path / "one"), results(tmp_path / "two")
    assert two["worst"]["load"] == pytest.approx(one["worst"]["load"], rel=1e-6)
    assert two["worst"]["shape"] == pytest.approx(one["worst"]["shape"], abs=1e-6)


@pytest.mark.parametrize(("more", "said"), [
    ([], "add --amplitude"), (["--amplitude", "1", "--quantile", "0.6"], "below 0.5"),
    (["--amplitude", "-1"], "amplitude"),
    (["--amplitude", "1", "--nodes", "--correlation", "2"], "both given"),
    (["--amplitude", "1", "--samples", "1"], "--samples is 1; it must be 0 or at least 2")])
def test_wrong_options_are_named(tmp_path, more, said):
    done = CliRunner().invoke(app, ["imperfections", "roorda-frame", "-o", str(tmp_path / "a"), *more])
    assert said in str(done.exception) + done.output


@pytest.mark.slow
def test_quantile_of_a_panel_is_inside_that_of_twenty_times_as_many_random_ones():
    """Of 600 random imperfections 5 % have loads below 0.485 to 0.514, an interval of 95 %."""
    case = load_case("cylinder-panel")(cells=(8, 5), form="naghdi-q2", to=1.5)
    _, ideal = perfect("cylinder-panel", case, 4)
    found = fx.Imperfections(case.scene, ideal.modes, partial(path_of, case)).quantile(0.05, 1e-3, samples=30)
    assert 0.485 < found.load < 0.514
    assert found.interval[1] - found.interval[0] < 0.04


def test_worst_over_nodes_of_two_bars():
    """The limit load goes with the third power of the rise, to which the apex adds twice what a foot does."""
    case = load_case("von-mises-truss")(rise=0.1)
    nodes = fx.nodal_shapes(case.scene.meshes)
    study = fx.Imperfections(case.scene, nodes, partial(path_of, case))
    worst = study.worst(0.01)[0]
    found = dict(zip([tuple(shape.place[:2]) for shape in nodes], worst.coefficients, strict=True))
    feet = found[-1.0, 0.0], found[1.0, 0.0]
    assert feet == pytest.approx([-found[0.0, 0.1] / 2] * 2, rel=0.02)
    assert np.linalg.norm(worst.coefficients) == pytest.approx(0.01)
    perfect_load = study.at([0.0] * 3).load
    assert worst.load == pytest.approx(perfect_load * (1 - 0.1 * 1.5**0.5) ** 3, rel=3e-3)


def test_nodes_of_several_meshes_are_moved_once():
    scene = load_case("star-dome")().scene
    assert len(fx.nodal_shapes(scene.meshes)) == 3 * 13
    assert len(fx.nodal_shapes([*scene.meshes, *scene.meshes])) == 3 * 13
    assert on_two_processes("import sheetfx as fx\nfrom sheetfx.scenes import load_case\n"
                            "print(len(fx.nodal_shapes(load_case('star-dome')().scene.meshes)))")[0] == "39"


@pytest.mark.slow
@pytest.mark.parametrize("reduced", ["0", "100"])
def test_worst_over_nodes_is_worse_than_over_modes(reduced, tmp_path):
    options = ["--nodes", "--amplitude", "0.1", "--shapes", "2", "--samples", "0", "--reduced", reduced]
    done = CliRunner().invoke(app, ["imperfections", "star-dome", *options, "-o", str(tmp_path)])
    assert done.exit_code == 0, done.output
    assert results(tmp_path)["worst"]["load"] == pytest.approx(2.60552e-4, rel=1e-4)  # 2.6181e-4 over two modes


@pytest.mark.slow
@pytest.mark.parametrize(("name", "options", "size", "count"), [
    ("star-dome", {}, 0.2, 5), ("cylinder-panel", {"cells": (8, 5), "form": "naghdi-q2", "to": 1.5}, 1e-3, 4),
    ("sinusoidal-arch", {}, 0.1, 3)])
def test_worst_shape_is_not_beaten_by_500_random_ones(name, options, size, count):
    case = load_case(name)(**options)
    _, ideal = perfect(name, case, count)
    study = fx.Imperfections(case.scene, ideal.modes, partial(path_of, case))
    worst = study.worst(size)[0]
    ways = np.random.default_rng(3).standard_normal((500, len(ideal.modes)))
    least = min(study.at(size * way / np.linalg.norm(way)).load for way in ways)
    assert least >= worst.load * (1 - 1e-3)
