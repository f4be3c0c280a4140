from contextlib import suppress

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ross_payload.audio.listener.feed import source_of
from ross_payload.audio.sinks.rtp_sink import RtpOptions, unicast
from ross_payload.config.table import validated
from ross_payload.errors import ConfigError
from ross_payload.transport.rtp.session_description import Media, Session, described, parsed

GOOD = described(Session(Media.of("opus", 16000), "192.0.2.7", 5004, "target"))


@pytest.mark.parametrize("codec", ["opus", "L16"])
@pytest.mark.parametrize("rate", [16000, 24000, 44100, 48000])
@pytest.mark.parametrize("host", ["192.0.2.7", "fd00::7"])
def test_what_is_described_is_read(codec, rate, host):
    session = Session(Media.of(codec, rate), host, 5004, "source 2")
    read = parsed(described(session), "it")
    assert (read.media, read.host, read.port, read.title) == (session.media, host, 5004, "source 2")


@pytest.mark.parametrize(
    ("text", "wanted"),
    [
        ("", "it: expected a session description (SDP), which begins with v=0"),
        ("<html>", "begins with v=0"),
        (GOOD.replace("m=audio", "m=video"), "expected a line m=audio PORT RTP/AVP TYPE"),
        (GOOD.replace("5004", "99999"), "expected a port from 1 to 65535, got '99999'"),
        (GOOD.replace("opus/48000/2", "G722/8000"), "expected opus/48000/2 or L16 with one channel, got 'G722/8000'"),
        (GOOD.replace("opus/48000/2", "L16/48000/2"), "expected opus/48000/2 or L16 with one channel"),
        (GOOD.replace("c=IN IP4 192.0.2.7", "c=IN IP4 here"), "expected a line c=IN IP4 ADDRESS, got 'here'"),
    ],
)
def test_what_cannot_be_played_is_refused_in_one_line(text, wanted):
    with pytest.raises(ConfigError) as error:
        parsed(text, "it")
    assert wanted in str(error.value)
    assert "\n" not in str(error.value)


@given(
    st.text(max_size=200).map(lambda text: "v=0\n" + text) | st.lists(st.sampled_from(GOOD.splitlines())).map("\n".join)
)
def test_any_text_is_read_or_refused(text):
    with suppress(ConfigError):
        assert parsed(text, "it").port > 0


@given(st.text(max_size=60) | st.text(max_size=40).map("rtp://".__add__) | st.text(max_size=40).map("tcp://".__add__))
def test_any_url_is_read_or_refused(url):
    try:
        source_of(url)
    except ConfigError as error:
        assert "expected" in str(error) or "cannot be read" in str(error)


@pytest.mark.parametrize(
    ("address", "why"),
    [
        ("239.1.2.3", "which is multicast"),
        ("ff02::1", "which is multicast"),
        ("::ffff:239.1.2.3", "which is multicast"),
        ("::ffff:255.255.255.255", "which is broadcast"),
        ("255.255.255.255", "which is broadcast"),
        ("0.0.0.0", "which is no address in particular"),  # noqa: S104 - is refused
        ("::", "which is no address in particular"),
        ("ground.local", "expected one like 192.168.1.20 or fd00::20, got 'ground.local'"),
        ("", "got ''"),
    ],
)
def test_only_one_named_computer_is_sent_to(address, why):
    with pytest.raises(ValueError, match=why):
        unicast(address)
    with pytest.raises(ConfigError, match=f"listening.streams.options: address: .*{why}"):
        validated(RtpOptions, {"address": address}, "listening.streams.options")


def test_a_codec_is_known_in_any_case_and_others_are_not():
    assert validated(RtpOptions, {"address": "192.0.2.7", "codec": "OPUS"}, "it").codec == "opus"
    assert validated(RtpOptions, {"address": "192.0.2.7", "codec": "l16"}, "it").codec == "L16"
    with pytest.raises(ConfigError, match="codec"):
        validated(RtpOptions, {"address": "192.0.2.7", "codec": "mp3"}, "it")
