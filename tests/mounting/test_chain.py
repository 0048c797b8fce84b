"""Selection of the tree that is mounted."""

import pytest

from aerodrake.mounting.chain import select_tree
from aerodrake.support.errors import BadInput
from tests.arm_urdfs import ARM, joint, link, read, robot

TWO_ARMS = robot(
    *map(link, ("torso", "left", "left_hand", "right", "right_hand", "stray")),
    joint("l1", "torso", "left"),
    joint("l2", "left", "left_hand"),
    joint("r1", "torso", "right"),
    joint("r2", "right", "right_hand"),
)


@pytest.fixture(scope="module")
def two_arms(tmp_path_factory):
    return read(TWO_ARMS, tmp_path_factory.mktemp("arm")).arm


def names(arm) -> list[str]:
    return [part.name for part in arm.links]


def test_links_of_other_trees_are_removed(two_arms):
    arm, (sentence,) = select_tree(two_arms, "left_hand")
    assert names(arm) == ["torso", "left", "left_hand", "right", "right_hand"]
    assert sentence == "links outside the tree below 'torso' are removed: stray"


def test_a_root_cuts_the_rest_off(two_arms):
    arm, _ = select_tree(two_arms, "left_hand", root="left")
    assert names(arm) == ["left", "left_hand"] and [j.name for j in arm.joints] == ["l2"]


@pytest.mark.parametrize(
    ("tool", "root", "message"),
    [
        ("left_hnd", "", "tool: expected a link, got 'left_hnd'; did you mean 'left_hand'"),
        ("left_hand", "lft", "root: expected a link, got 'lft'; did you mean 'left'"),
        ("left_hand", "right", "root: expected a link above 'left_hand', got 'right'"),
        ("left_hand", "left_hand", "root: expected a link above 'left_hand', got 'left_hand'"),
    ],
)
def test_wrong_links_are_named(two_arms, tool, root, message):
    with pytest.raises(BadInput) as caught:
        select_tree(two_arms, tool, root)
    assert message in str(caught.value)


@pytest.mark.parametrize("kind", ["fixed", "floating", "planar"])
def test_links_of_the_world_are_removed(kind, tmp_path):
    text = ARM.replace('type="fixed"', f'type="{kind}"')
    arm, (sentence,) = select_tree(read(text, tmp_path).arm, "tool")
    assert arm.root == "base" and sentence.startswith("link 'world' is removed")


def test_a_root_that_moves_or_weighs_stays(tmp_path):
    for text in (
        ARM.replace('type="fixed"', 'type="continuous"'),
        ARM.replace(link("world", 0), link("world", 1)),
    ):
        assert select_tree(read(text, tmp_path).arm, "tool").arm.root == "world"
