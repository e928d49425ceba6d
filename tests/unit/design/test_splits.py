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
from refusing import refuses


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


@pytest.mark.parametrize("muscles", [1, 2, 5, 8])
def test_partitions_are_compositions_without_their_order(muscles):
    assert plain(partitions(muscles)) == sorted(
        {tuple(sorted(row)) for row in plain(compositions(muscles))}
    )


def test_a_composition_is_written_and_read_split():
    assert read_split("1+4") == (1, 4) and read_split(" 2 + 1+ 12 ") == (2, 1, 12)
    assert label((1, 4, 0)) == "1+4"
    for wrong in ("", "1+", "0+2", "1+a", "1-4", "-1", "1.0"):
        with refuses("splits"):
            read_split(wrong)


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
