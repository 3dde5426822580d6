"""The net: groups by indices and masks, spans, mistakes."""

import numpy as np
import pytest

from netdae.core.errors import InputError
from netdae.model.net import CableNet

NODES, CABLES = [[0, 0, 0], [1.0, 0, 0], [1.0, 2.0, 0], [0, 2.0, 0.5]], [[0, 1], [2, 1], [2, 3]]


@pytest.mark.parametrize(
    "members", [[3, 1, 1], (1, 3), np.array([3, 1], dtype=np.uint8), [False, True, False, True]]
)
def test_a_group_is_reported_by_indices_or_by_a_mask(members):
    net = CableNet(NODES, CABLES, {"some": members}, {"some": np.arange(3) < 2})
    np.testing.assert_array_equal(net.nodes_of("some"), [1, 3])
    np.testing.assert_array_equal(net.cables_of("some"), [0, 1])


def test_a_group_may_be_empty():
    net = CableNet(NODES, CABLES, {"none": []}, {"none": np.zeros(3, dtype=bool)})
    assert len(net.nodes_of("none")) == len(net.cables_of("none")) == 0


@pytest.mark.parametrize(
    ("members", "words"),
    [
        ([0.0, 1.7], r"\(2,\) of float64: give whole numbers, or a mask of 4 booleans"),
        ([True, False], r"\(2,\) of bool: give whole numbers"),
        (["1", "2"], "give whole numbers"),
        ([0, 4], "holds node 4, but the net has 4 nodes"),
        ([-1], "holds node -1"),
    ],
)
def test_what_is_no_group_is_refused(members, words):
    with pytest.raises(InputError, match=f"^node group 'some' .*{words}"):
        CableNet(NODES, CABLES, {"some": members})


def test_spans_go_from_the_first_to_the_second_node_and_turn_with_the_net():
    net = CableNet(NODES, CABLES, rest_length=[1.0, 1.0, 1.0])
    np.testing.assert_array_equal(net.spans, [[1, 0, 0], [0, -2, 0], [-1, 0, 0.5]])
    np.testing.assert_array_equal(net.with_nodes(-net.nodes).spans, -net.spans)
