import numpy as np

from ecyl_ros.analysis.plots import MAX_POINTS, _drawn, _unit


def test_thinned_curves_keep_their_peaks():
    """A single-sample spike in a long signal is drawn, with its neighbours' order kept."""
    x = np.arange(500_000) / 1000.0
    y = np.sin(x)
    y[123_457] = 9.0
    y[-1] = -4.0
    drawn_x, drawn_y = _drawn(x, y)
    assert drawn_x.size <= MAX_POINTS + 1
    assert drawn_y.max() == 9.0 and drawn_y.min() == -4.0
    assert np.all(np.diff(drawn_x) > 0)


def test_units_keep_numbers_short():
    """The largest value of an axis lies between 1 and 1000 of its unit."""
    for largest, unit in ((2e-5, "µm"), (6e-3, "mm"), (0.4, "mm"), (1.5, "m"), (3e-9, "nm")):
        scale, name = _unit(np.array([0.0, -largest]), "m")
        assert name == unit and 1.0 <= largest * scale < 1000.0
    assert _unit(np.zeros(3), "m") == (1e6, "µm")
