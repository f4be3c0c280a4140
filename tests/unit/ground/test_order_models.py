"""The models of orders and the schema that others get of them accept the same, and the page's protocol no less."""

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from jsonschema_rs import validator_for

from ross_payload.ground.client.command_types import Inform, Listen, Order
from ross_payload.ground.client.order_json import order_of
from ross_payload.ground.client.order_models import MODELS
from ross_payload.ground.client.stream_orders import Enrol, Stream

VALIDATORS = {kind: validator_for(model.model_json_schema()) for kind, model in MODELS.items()}
NAMES = sorted({name for model in MODELS.values() for name in model.model_fields} - {"kind"})
WORDS = [
    "mixture", "target", "source", "azimuth", "opus", "L16", "mp3", "127.0.0.1", "192.168.1.20", "0.0.0.0",  # noqa: S104
    "239.0.0.1", "255.255.255.255", "1.2.3", "223.255.255.255", "1.2.3.04", "", "Target",
]  # fmt: skip
numbers = st.one_of(
    st.sampled_from(
        [-361, -360, -100, -1, 0, 0.5, 1, 5, 6, 40, 60, 61, 254, 255, 256, 300, 360, 5004, 9999, 65536, 2.0]
    ),
    st.floats(allow_nan=False, allow_infinity=False),
)
values = st.one_of(
    numbers, st.booleans(), st.sampled_from(WORDS), st.none(), st.lists(numbers, max_size=7), st.just({"deg": 1})
)
likely = {
    "what": st.sampled_from(WORDS[:4]), "codec": st.sampled_from(WORDS[4:6]), "address": st.sampled_from(WORDS[7:9]),
    "azimuths": st.lists(st.floats(-360, 360), min_size=1, max_size=6), "consent": st.just(True),
    "muted": st.booleans(), "on": st.booleans(), "port": st.integers(1, 65535), "gain": st.floats(-100, 40),
    "seconds": st.floats(0, 60), "voice": st.integers(0, 9999),
}  # fmt: skip
likely = {name: likely.get(name, st.integers(0, 5)) for name in NAMES}
orders = st.tuples(
    st.sampled_from(sorted(MODELS)),
    st.one_of(
        st.fixed_dictionaries({}, optional=likely),
        st.fixed_dictionaries({}, optional=dict.fromkeys(["heading", "source", "sorce"], values)),
        st.sampled_from(sorted(MODELS)).flatmap(lambda kind: st.fixed_dictionaries({}, optional=of(kind))),
    ),
)


def of(kind):
    """Strategies of the fields of a kind."""
    return {name: likely[name] | values for name in MODELS[kind].model_fields if name != "kind"}


def is_accepted(order):
    try:
        return MODELS[order["kind"]].model_validate(order).order() is not None
    except ValueError:
        return False


@pytest.mark.soak
@settings(max_examples=200, deadline=None, derandomize=True)
@given(orders)
@example(("stream", {"address": "127.0.0.1", "port": 5004, "what": "source"}))
@example(("stream", {"address": "224.0.0.1", "port": 5004}))
@example(("stream", {"stream": 0, "port": 5004}))
@example(("enrol", {"source": 1, "azimuth": 2, "consent": True}))
@example(("enrol", {"source": 1, "consent": False}))
@example(("listen", {"source": 1, "azimuth": 2}))
@example(("stop_stream", {"stream": 0, "address": "127.0.0.1", "port": 5004}))
@example(("listen", {"source": 2.0}))
@example(("park", {"kind": "park", "heading": 1}))
def test_the_schema_accepts_what_the_models_accept_and_nothing_else(given_order):
    kind, fields = given_order
    order = {**fields, "kind": kind}
    assert VALIDATORS[kind].is_valid(order) == is_accepted(order)


@settings(max_examples=100, deadline=None, derandomize=True)
@given(orders)
def test_what_a_model_accepts_is_the_same_order_in_the_pages_protocol(given_order):
    kind, fields = given_order
    order = {**fields, "kind": kind}
    if is_accepted(order):
        assert order_of(order | {"number": 3, "muted_by": None}) == MODELS[kind].model_validate(order).order()


def test_an_order_is_made_of_what_was_given_and_nothing_else():
    made = MODELS["stream"].model_validate({"kind": "stream", "stream": 1, "what": "azimuth", "azimuth": 0}).order()
    assert made == Stream(stream=1, what="azimuth", azimuth=0.0)
    assert MODELS["inform"].model_validate({"kind": "inform", "azimuths": [40, 155], "first": 1}).order() == Inform(
        (40.0, 155.0), 1
    )
    assert MODELS["listen"].model_validate({"kind": "listen", "source": 0}).order() == Listen(source=0)
    enrol = {"kind": "enrol", "azimuth": 90, "consent": True, "voice": 3, "seconds": 20}
    assert MODELS["enrol"].model_validate(enrol).order() == Enrol(None, 90.0, 20.0, True, 3)


def test_every_order_that_there_is_has_a_model():
    assert {model.makes.__name__ for model in MODELS.values()} == {each.__name__ for each in subclasses(Order)}


def subclasses(kind):
    return {each for inner in kind.__subclasses__() for each in (inner, *subclasses(inner))}
