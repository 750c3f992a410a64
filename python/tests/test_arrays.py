"""Shapes, types and memory of the arguments."""

import threading

import numpy as np
import pytest
from conftest import robot_file, same_bits, states
from hypothesis import given, settings
from hypothesis import strategies as st

import newtau

FUNCTIONS = {
    "inverse_dynamics": (3, lambda n: (n,)),
    "gravity": (1, lambda n: (n,)),
    "mass_matrix": (1, lambda n: (n, n)),
    "forward_dynamics": (3, lambda n: (n,)),
    "jacobian": (1, lambda n: (6, n)),
    "regressor": (3, lambda n: (n, 10 * n)),
    "tip_pose": (1, lambda n: (4, 4)),
}


@pytest.mark.parametrize("name", FUNCTIONS)
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("batch", [0, 1, 5, 12, 13, 33, 3000])
def test_a_batch_has_the_bits_of_its_states(arm, name, dtype, batch):
    inputs, shape = FUNCTIONS[name]
    function = getattr(arm, name)
    lists = states(arm.n, batch, dtype)[:inputs]
    found = function(*lists)
    assert found.shape == (batch, *shape(arm.n)) and found.dtype == dtype
    for k in range(0, batch, max(1, batch // 40)):
        assert same_bits(found[k], function(*(each[k] for each in lists)))


@given(data=st.data())
@settings(max_examples=60, deadline=None)
def test_strided_memory_has_the_bits_of_contiguous_memory(arms, data):
    arm = arms[data.draw(st.sampled_from(sorted(arms)))]
    dtype = data.draw(st.sampled_from([np.float32, np.float64]))
    batch, step = data.draw(st.integers(1, 80)), data.draw(st.sampled_from([-3, -1, 2, 3]))
    wide = [
        np.random.default_rng(data.draw(st.integers(0, 1000))).uniform(-3, 3, (abs(step) * batch, 2 * arm.n)).astype(dtype)
        for _ in range(3)
    ]
    views = [each[::step, ::2] for each in wide]
    turned = [np.asfortranarray(each) for each in views]
    plain = [np.ascontiguousarray(each) for each in views]
    for name, (inputs, _) in FUNCTIONS.items():
        function = getattr(arm, name)
        expected = function(*plain[:inputs])
        assert same_bits(function(*views[:inputs]), expected)
        assert same_bits(function(*turned[:inputs]), expected)


@given(data=st.data())
@settings(max_examples=40, deadline=None)
def test_any_numbers_in_a_batch_give_the_bits_of_one_state(arms, data):
    arm = arms[data.draw(st.sampled_from(sorted(arms)))]
    width = data.draw(st.sampled_from([32, 64]))
    dtype = np.dtype(f"f{width // 8}")
    number = st.floats(width=width) | st.sampled_from([0.0, -0.0, 1.0, 1e4, float("nan"), float("inf")])
    row = st.lists(number, min_size=3 * arm.n, max_size=3 * arm.n)
    rows = np.array(data.draw(st.lists(row, min_size=2, max_size=4)), dtype).reshape(-1, 3, arm.n)
    lists = [np.ascontiguousarray(np.resize(rows[:, k], (40, arm.n))) for k in range(3)]
    found = arm.inverse_dynamics(*lists)
    for k in range(len(rows)):
        alone = arm.inverse_dynamics(*(each[k] for each in lists))
        numbers = ~np.isnan(alone)
        assert np.array_equal(np.isnan(found[k]), ~numbers)
        assert found[k][numbers].tobytes() == alone[numbers].tobytes()


def test_unaligned_and_swapped_memory_is_copied(arms):
    arm = arms["ur5"]
    q, qd, qdd = states(6, 20)
    expected = arm.inverse_dynamics(q, qd, qdd)
    packed = np.zeros(20, dtype=[("flag", "u1"), ("q", "f8", 6)])
    packed["q"] = q
    assert not packed["q"].flags.aligned
    assert same_bits(arm.inverse_dynamics(packed["q"], qd, qdd), expected)
    swapped = q.astype(">f8")
    assert same_bits(arm.inverse_dynamics(swapped, qd, qdd), expected)


@pytest.mark.parametrize(
    "other, expected",
    [
        (np.int8, np.float32),
        (np.uint8, np.float32),
        (np.int16, np.float32),
        (np.uint16, np.float32),
        (np.bool_, np.float32),
        (np.float16, np.float32),
        (np.int32, np.float64),
        (np.int64, np.float64),
        (np.float64, np.float64),
        (list, np.float64),
        (tuple, np.float64),
    ],
)
def test_float32_with_another_type_has_the_documented_precision(arms, other, expected):
    arm = arms["ur5"]
    q, _, qdd = states(6, 20, np.float32)
    whole = np.array([0, 1, 1, 0, 1, 0])
    qd = other(whole.tolist()) if other in (list, tuple) else whole.astype(other)
    found = arm.inverse_dynamics(q, qd, qdd)
    assert same_bits(found, arm.inverse_dynamics(*(np.asarray(each, dtype=expected) for each in (q, qd, qdd))))
    assert found.dtype == expected
    # Alone, none of these types is computed in float32.
    assert arm.gravity(qd).dtype == np.float64


def test_float16_with_int16_is_float32_as_in_numpy(arms):
    half, short = np.zeros(6, np.float16), np.zeros(6, np.int16)
    assert arms["ur5"].inverse_dynamics(half, short, short).dtype == np.float32
    assert arms["ur5"].inverse_dynamics(half, half, half).dtype == np.float64


def test_types_are_promoted_as_numpy_does(arms):
    arm = arms["puma560"]
    q, qd, qdd = states(6)
    single = [each.astype(np.float32) for each in (q, qd, qdd)]
    assert arm.inverse_dynamics(*single).dtype == np.float32
    mixed = arm.inverse_dynamics(single[0], qd, qdd)
    assert same_bits(mixed, arm.inverse_dynamics(single[0].astype(np.float64), qd, qdd))
    whole = np.array([0, 1, 2, 0, 1, 2])
    assert same_bits(arm.gravity(whole), arm.gravity(whole.astype(np.float64)))
    assert arm.gravity(list(whole)).dtype == np.float64
    assert arm.gravity(q.astype(np.float16)).dtype == np.float64


@pytest.mark.parametrize("bad", [np.zeros(6, complex), np.zeros(6, np.longdouble), np.zeros(6, object), np.array(["a"] * 6)])
def test_types_that_would_lose_numbers_are_refused(arms, bad):
    with pytest.raises(TypeError, match=r"^qd: found an array of .*; expected float64, float32"):
        arms["ur5"].inverse_dynamics(np.zeros(6), bad, np.zeros(6))


def test_masked_arrays_are_refused_with_advice_that_works(arms):
    arm = arms["ur5"]
    q, qd, qdd = states(6, 20)
    mask = np.zeros(q.shape, bool)
    mask[3, 2] = True
    masked = np.ma.masked_array(q, mask)
    message = r"^q: found a masked array; .*numpy\.ma\.filled\(q, numpy\.nan\).*numpy\.ma\.compress_rows\(q\)"
    for bad in (masked, masked[3], masked.astype(np.float32), np.ma.masked_array(q), [masked[3]] * 20, tuple(masked)):
        with pytest.raises(TypeError, match=message):
            arm.gravity(bad)
    with pytest.raises(TypeError, match="^qdd: found a masked array"):
        arm.inverse_dynamics(q, qd, np.ma.masked_array(qdd))
    with pytest.raises(TypeError, match="^out: found a masked array"):
        arm.gravity(q, out=np.ma.empty((20, 6)))
    # Both ways of the message.
    filled, expected = arm.gravity(np.ma.filled(masked, np.nan)), arm.gravity(q)
    others = np.arange(20) != 3
    assert np.isnan(filled[3]).any() and same_bits(filled[others], expected[others])
    assert same_bits(arm.gravity(np.ma.compress_rows(masked)), expected[others])
    # Other subclasses of ndarray are read.
    class Named(np.ndarray):
        pass

    assert same_bits(np.asarray(arm.gravity(q.view(Named))), expected)


def test_masked_gravity_and_payload_are_refused():
    masked = np.ma.masked_array([0.0, 0.0, -9.81], [False, False, True])
    with pytest.raises(TypeError, match="^gravity: found a masked array"):
        newtau.load(robot_file("ur5"), gravity=masked)
    with pytest.raises(TypeError, match="^payload.com: found a masked array"):
        newtau.load(robot_file("ur5"), payload=newtau.Payload(1.0, com=masked))


def test_a_list_for_one_state_is_used_for_all(arms):
    arm = arms["ur5"]
    q, qd, qdd = states(6, 50)
    found = arm.inverse_dynamics(q, qd[0], np.zeros(6))
    assert same_bits(found, arm.inverse_dynamics(q, np.tile(qd[0], (50, 1)), np.zeros((50, 6))))


@pytest.mark.parametrize(
    "shapes, message",
    [
        ([(5,), (6,), (6,)], r"q: found shape \(5,\); expected \(6,\) or \(batch, 6\)"),
        ([(6,), (), (6,)], r"qd: found shape \(\); expected \(6,\) or \(batch, 6\)"),
        ([(4, 6), (4, 6), (4, 5)], r"qdd: found shape \(4, 5\); expected \(6,\) or \(batch, 6\)"),
        ([(4, 6), (3, 6), (4, 6)], r"qd: found shape \(3, 6\); expected \(4, 6\), as q has"),
        ([(2, 4, 6), (6,), (6,)], r"q: found shape \(2, 4, 6\); expected"),
    ],
)
def test_a_wrong_shape_names_argument_found_and_expected(arms, shapes, message):
    with pytest.raises(ValueError, match=message):
        arms["ur5"].inverse_dynamics(*(np.zeros(shape) for shape in shapes))


def test_out_is_filled_and_returned(arms):
    arm = arms["ur5"]
    lists = states(6, 70)
    expected = arm.inverse_dynamics(*lists)
    out = np.empty((70, 6))
    assert arm.inverse_dynamics(*lists, out=out) is out and same_bits(out, expected)
    strided = np.empty((140, 12))[::2, ::-2]
    arm.inverse_dynamics(*lists, out=strided)
    assert np.array_equal(strided, expected)


def test_a_wrong_out_is_refused(arms):
    arm = arms["ur5"]
    lists = states(6, 4)
    with pytest.raises(ValueError, match=r"out: found shape \(4, 5\); expected \(4, 6\)"):
        arm.inverse_dynamics(*lists, out=np.empty((4, 5)))
    with pytest.raises(TypeError, match="out: found an array of float32; expected an array of float64"):
        arm.inverse_dynamics(*lists, out=np.empty((4, 6), np.float32))
    frozen = np.empty((4, 6))
    frozen.flags.writeable = False
    for out in (frozen, lists[0]):
        before = out.copy()
        with pytest.raises(ValueError, match="out: .*; expected a writeable array that shares no memory"):
            arm.inverse_dynamics(*lists, out=out)
        assert out.tobytes() == before.tobytes()


@pytest.mark.parametrize(
    "shape, strides",
    [
        ((5000, 6), (8, 8)),
        ((5000, 6), (0, 8)),
        ((5000, 6), (8, 0)),
        ((5000, 6), (40, 8)),
        ((5000, 6), (-40, 8)),
        ((5000, 6), (8, 39_992)),
        ((5000, 6), (16, 48)),
    ],
)
def test_an_out_whose_elements_share_memory_is_refused(arms, shape, strides):
    buffer = np.zeros(300_000)
    out = np.lib.stride_tricks.as_strided(buffer[200_000:] if strides[0] < 0 else buffer, shape, strides)
    q = states(6, 5000)[0]
    message = r"^out: found elements that share memory \(shape \(5000, 6\), strides .* bytes\); .*numpy\.empty\(\(5000, 6\)\)"
    with pytest.raises(ValueError, match=message):
        arms["ur5"].gravity(q, out=out)
    assert not buffer.any()


@given(data=st.data())
@settings(max_examples=200, deadline=None)
def test_no_accepted_out_shares_memory_and_every_slice_is_accepted(arms, data):
    arm, batch = arms["planar2r"], data.draw(st.integers(1, 6))
    q, buffer = states(2, batch)[0], np.zeros(400)
    expected = arm.gravity(q)
    strides = [8 * data.draw(st.integers(-12, 12)) for _ in range(2)]
    out = np.lib.stride_tricks.as_strided(buffer[200:], (batch, 2), strides)
    places = {row * strides[0] + column * strides[1] for row in range(batch) for column in range(2)}
    try:
        arm.gravity(q, out=out)
    except ValueError:
        assert not buffer.any()
    else:
        assert len(places) == 2 * batch and np.array_equal(out, expected)
    # A slice of an ordinary array, perhaps transposed or reversed.
    steps = [data.draw(st.sampled_from([-3, -2, -1, 1, 2, 3])) for _ in range(2)]
    wide = np.zeros((abs(steps[0]) * batch, abs(steps[1]) * 2), order=data.draw(st.sampled_from("CF")))
    part = wide[:: steps[0], :: steps[1]]
    arm.gravity(q, out=part)
    assert np.array_equal(part, expected)


def test_an_out_that_reaches_into_an_input_by_another_view_is_refused(arms):
    arm, storage = arms["ur5"], bytearray(8 * 240)
    for view in (
        lambda base: np.lib.stride_tricks.as_strided(base, (20, 6), (48, 8)),
        lambda base: np.frombuffer(memoryview(storage)).reshape(40, 6)[5:25],
    ):
        base = np.frombuffer(memoryview(storage)).reshape(40, 6)
        q = base[:20]
        with pytest.raises(ValueError, match="^out: .*; expected a writeable array that shares no memory with an input"):
            arm.gravity(q, out=view(base))
    # Negative control: interleaved elements, and disjoint views of one buffer.
    both = np.zeros((20, 12))
    both[:, ::2] = states(6, 20)[0]
    expected = arm.gravity(both[:, ::2])
    arm.gravity(both[:, ::2], out=both[:, 1::2])
    assert np.array_equal(both[:, 1::2], expected)
    q = np.frombuffer(memoryview(storage)).reshape(40, 6)[:20]
    q[:] = both[:, ::2]
    out = np.lib.stride_tricks.as_strided(np.frombuffer(memoryview(storage))[120:], (20, 6), (48, 8))
    assert same_bits(arm.gravity(q, out=out).copy(), expected)


def test_threads_compute_at_the_same_time_and_agree(arms):
    arm = arms["puma560"]
    lists = states(6, 5000)
    expected, found = arm.inverse_dynamics(*lists), [None] * 4

    def work(k):
        found[k] = arm.inverse_dynamics(*lists)

    threads = [threading.Thread(target=work, args=(k,)) for k in range(len(found))]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert all(same_bits(each, expected) for each in found)
