"""What was used last is kept."""

from mesh_navigation.base.recent import Recent


def test_what_is_taken_is_gone_until_it_is_put_back():
    cache = Recent(3)
    assert cache.take("goal") is None
    cache.put("goal", 1)
    assert cache.take("goal") == 1
    assert cache.take("goal") is None
    cache.put("goal", 2)
    cache.put("goal", 3)
    assert cache.take("goal") == 3


def test_those_used_longest_ago_go():
    cache = Recent(3)
    for goal in "abc":
        cache.put(goal, goal.upper())
    cache.put("a", cache.take("a"))
    cache.put("d", "D")
    assert [cache.take(goal) for goal in "abcd"] == ["A", None, "C", "D"]
