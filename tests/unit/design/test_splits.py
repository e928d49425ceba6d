from itertools import product

import numpy as np
import pytest

from fascicle.core.errors import InvalidInputError
from fascicle.design.designs import label
from fascicle.design.space import (
    MAX_SPLITS,
    check_splits,
    compositions,
    number_of_splits,
    partitions,
    read_split,
)


def plain(rows):
    return sorted(tuple(int(n) for n in row if n) for row in rows)


@pytest.mark.parametrize("muscles", [1, 2, 3, 5, pytest.param(8, marks=pytest.mark.slow)])
def test_compositions_are_complete(muscles):
    every = [
        row
        for units in range(1, muscles + 1)
        for row in product(range(1, muscles + 1), repeat=units)
        if sum(row) == muscles
    ]
    assert plain(compositions(muscles)) == sorted(every)


def test_there_are_2048_of_twelve_muscles():
    counts = compositions(12)
    assert counts.shape == (2048, 12)
    assert np.all(counts.sum(axis=1) == 12)
    assert label(counts[0]) == "12" and label(counts[-1]) == "+".join("1" * 12)


@pytest.mark.parametrize("muscles", [1, 2, 5, 8])
def test_partitions_are_compositions_without_their_order(muscles):
    assert plain(partitions(muscles)) == sorted(
        {tuple(sorted(row)) for row in plain(compositions(muscles))}
    )


def test_there_are_5604_partitions_of_thirty():
    # Euler's p(30)
    counts = partitions(30)
    assert counts.shape == (5604, 30)
    assert np.all(counts.sum(axis=1) == 30)
    assert label(counts[0]) == "30"


def test_empty_units_come_last():
    for counts in (compositions(6), partitions(6)):
        there = counts > 0
        assert np.all(there[:, :-1] | ~there[:, 1:])


def test_a_composition_is_written_and_read_split():
    assert read_split("1+4") == (1, 4) and read_split(" 2 + 1+ 12 ") == (2, 1, 12)
    assert label((1, 4, 0)) == "1+4"
    for wrong in ("", "1+", "0+2", "1+a", "1-4", "-1", "1.0"):
        with pytest.raises(ValueError, match="written like '1\\+4'"):
            read_split(wrong)


@pytest.mark.parametrize("make", [compositions, partitions])
@pytest.mark.parametrize("muscles", [0, -1, 101])
def test_numbers_out_of_range(make, muscles):
    with pytest.raises(ValueError, match="`muscles` must lie in"):
        make(muscles)


@pytest.mark.parametrize(("make", "kind"), [(compositions, "all"), (partitions, "partitions")])
@pytest.mark.parametrize("muscles", [1, 2, 7, 12])
def test_limited_units_are_a_subset_in_order(make, kind, muscles):
    every = make(muscles)
    for units in range(1, muscles + 2):
        rows = make(muscles, units)
        width = rows.shape[1]
        assert width == min(units, muscles)
        np.testing.assert_array_equal(rows, every[(every > 0).sum(axis=1) <= units][:, :width])
        assert len(rows) == number_of_splits(muscles, kind, units)


def test_many_muscles_in_few_units():
    assert len(compositions(60, 3)) == 1 + 59 + 59 * 58 // 2
    assert len(partitions(100, 2)) == 51
    # by Hardy and Ramanujan, 1918
    assert number_of_splits(100, "partitions") == 190_569_292


@pytest.mark.parametrize("numbers", [(60,), (100,), (22, 23), (1, 60)])
def test_too_many_splits_are_refused_at_once(numbers):
    """And what is told to do instead leaves few enough."""
    with pytest.raises(InvalidInputError) as refused:
        check_splits(numbers, "all")
    assert refused.value.argument == "muscles"
    units = int(refused.value.remedy.split()[0])
    check_splits(numbers, "all", units)
    assert sum(number_of_splits(n, "all", units + 1) for n in numbers) > MAX_SPLITS
    parted = sum(number_of_splits(n, "partitions") for n in numbers) <= MAX_SPLITS
    assert ("partitions" in refused.value.remedy) is parted
