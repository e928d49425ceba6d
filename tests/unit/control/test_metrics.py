"""Which runs none betters in both prices."""

from numpy.testing import assert_array_equal

from fascicle import control


def test_the_front_holds_runs_that_no_other_beats():
    # by hand: the third is as deep as the second and dearer, the last is bettered in both
    dips, energies = [6.0, 1.0, 1.0, 0.5, 7.0], [10.0, 11.0, 12.0, 20.0, 30.0]
    assert_array_equal(control.pareto_front(dips, energies), [True, True, False, True, False])


def test_equally_good_runs_are_all_on_the_front():
    assert_array_equal(control.pareto_front([1.0, 1.0, 2.0], [5.0, 5.0, 5.0]), [True, True, False])
    assert_array_equal(control.pareto_front([3.0], [0.0]), [True])
