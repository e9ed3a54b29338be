"""Which sets are searched: by a look long enough to tell where flanks meet."""

from __future__ import annotations

from other_make import replayed

from ecyl_ros.gap.compete.candidates import Candidates
from ecyl_ros.gap.fit.fit import Fitter
from ecyl_ros.gap.split import held_out

TRUE = {
    "constant_load": {"force_n": -204.4},
    "torque_constant_error": {"torque_constant_nm_per_a": 0.7933},
}


def test_a_pair_is_found_where_its_first_steps_are_short() -> None:
    """A load found alone at a wrong torque constant, which has to grow by a tenth with the right
    one: the pair comes first, at the noise floor, before what only resembles it."""
    replay = replayed(TRUE, seed=6)
    names = (*TRUE, "current_sensor_gain", "load_inertia_error", "rotor_inertia_error")
    field = Candidates(Fitter(replay, held_out(replay.time_s)), names)
    singles = field.singles(lambda share: None)
    assert singles[0].names == ("constant_load",)
    best = field.larger(singles[:2], singles)[0]
    assert set(best.names) == set(TRUE)
    assert best.fitted < 1.3 * field.fitter.perfect**2
