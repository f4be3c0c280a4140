"""PCM over a byte stream: what goes in comes out, however the stream is cut."""

import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ross_protocols.audio.pcm import LONGEST_HEADER, WIDTHS, Decoder, Header, PcmError, decode, encode, encode_header

FORMS = st.sampled_from(sorted(WIDTHS))


@st.composite
def streams(draw):
    form, channels = draw(FORMS), draw(st.integers(1, 6))
    bits = {"s16le": 15, "s24le": 23, "f32le": 23}[form]
    count = st.integers(-(2**bits), 2**bits - 1)
    values = draw(st.lists(st.lists(count, min_size=channels, max_size=channels), min_size=1, max_size=20))
    frames = (np.array(values, np.float64) / 2**bits).astype(np.float32)
    return Header(draw(st.integers(1, 192_000)), channels, form), frames


@pytest.mark.parametrize("line", [b"[" * (LONGEST_HEADER - 4) + b"\n", b"{" * 900 + b"\n", b"null\n"])
def test_a_header_that_is_none_is_refused(line):
    with pytest.raises(PcmError, match="expected a line like"):
        Decoder().feed(line)


@given(streams(), st.data())
def test_a_stream_cut_anywhere_gives_the_same_samples(stream, data):
    header, frames = stream
    sent = encode_header(header) + encode(frames, header.format)
    cuts = sorted(data.draw(st.lists(st.integers(0, len(sent)), max_size=10)))
    decoder = Decoder()
    pieces = [sent[begin:end] for begin, end in zip([0, *cuts], [*cuts, len(sent)], strict=True)]
    heard = [piece for piece in map(decoder.feed, pieces) if piece.size]
    assert decoder.header == header
    assert np.array_equal(np.concatenate(heard), frames)


@given(st.binary(max_size=200))
def test_no_bytes_break_the_decoder_with_anything_but_its_own_error(data):
    decoder = Decoder()
    try:
        decoder.feed(data + b"\n")
    except PcmError:
        assert decoder.header is None


def test_integers_clip_at_full_scale_and_do_not_wrap():
    loud = np.array([[1.5, -1.5]], np.float32)
    assert decode(encode(loud, "s24le"), "s24le", 2)[0] == pytest.approx([1 - 2**-23, -1])
    assert decode(encode(loud, "s16le"), "s16le", 2)[0] == pytest.approx([1 - 2**-15, -1])


def test_24_bits_are_little_endian_twos_complement():
    assert encode(np.array([[2**-23, -(2**-23)]], np.float32), "s24le").hex() == "010000ffffff"


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"rate_hz": None}, "rate_hz: expected a whole number from 1 to 192000, got None"),
        ({"rate_hz": 16000.0}, "rate_hz: expected a whole number from 1 to 192000, got 16000.0"),
        ({"channels": 0}, "channels: expected a whole number from 1 to 64, got 0"),
        ({"channels": True}, "channels: expected a whole number from 1 to 64, got True"),
        ({"format": "mp3"}, "format: expected one of s16le, s24le, f32le, got 'mp3'"),
        ({"ross_pcm": 2}, "expected version 1, got 2"),
    ],
)
def test_a_wrong_header_is_told_in_one_line(change, said):
    line = {"ross_pcm": 1, "rate_hz": 16000, "channels": 2, "format": "s24le"} | change
    with pytest.raises(PcmError, match=said):
        Decoder().feed(json.dumps(line).encode() + b"\n")


def test_a_stream_without_a_header_does_not_grow_without_end():
    with pytest.raises(PcmError, match=f"no PCM header within {LONGEST_HEADER} bytes"):
        Decoder().feed(b"\0" * (LONGEST_HEADER + 1))
