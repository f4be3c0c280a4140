"""Addresses: the URLs of links."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ross_payload.errors import ConfigError
from ross_payload.transport.link_url import Serial, Tcp, Udp, parse


@pytest.mark.parametrize(
    ("url", "address"),
    [
        ("udpin:0.0.0.0:14550", Udp("0.0.0.0", 14550, listen=True)),  # noqa: S104
        ("udpin::14550", Udp("127.0.0.1", 14550, listen=True)),
        ("udpout:ground.local:14550", Udp("ground.local", 14550, listen=False)),
        ("udpout:[fe80::1]:1", Udp("fe80::1", 1, listen=False)),
        ("tcp:127.0.0.1:65535", Tcp("127.0.0.1", 65535, listen=False)),
        ("tcpin::5760", Tcp("127.0.0.1", 5760, listen=True)),
        ("tcpin:0.0.0.0:5760", Tcp("0.0.0.0", 5760, listen=True)),  # noqa: S104
        ("serial:/dev/ttyUSB0:57600", Serial("/dev/ttyUSB0", 57600)),
        ("serial:/dev/serial/by-path/pci-0:1:921600", Serial("/dev/serial/by-path/pci-0:1", 921600)),
        ("serial:/dev/ttyACM0:auto", Serial("/dev/ttyACM0", None)),
    ],
)
def test_a_url_is_read(url: str, address: object) -> None:
    assert parse(url) == address


@pytest.mark.parametrize(
    ("url", "says"),
    [
        ("", "expected udpin:, udpout:"),
        ("udp:127.0.0.1:14550", "expected udpin:, udpout:"),
        ("127.0.0.1:14550", "expected udpin:, udpout:"),
        ("udpout:127.0.0.1", "expected udpin:, udpout:"),
        ("udpout::14550", "host is missing"),
        ("tcp:127.0.0.1:0", "expected a port from 1 to 65535, got '0'"),
        ("tcp:127.0.0.1:65536", "got '65536'"),
        ("tcp:127.0.0.1:-1", "got '-1'"),
        ("tcp:127.0.0.1:http", "got 'http'"),
        ("tcp:127.0.0.1:", "got ''"),
        ("tcp:fe80::1:5760", "IPv6 host in brackets"),
        ("tcp:[fe80::1:5760", "IPv6 host in brackets"),
        ("serial:/dev/ttyUSB0", "expected udpin:, udpout:"),
        ("serial:/dev/ttyUSB0:fast", "got 'fast'"),
        ("serial:/dev/ttyUSB0:0", "got '0'"),
    ],
)
def test_what_is_no_url_is_explained(url: str, says: str) -> None:
    with pytest.raises(ConfigError) as error:
        parse(url)
    assert says in str(error.value)
    assert f"'{url}'" in str(error.value)
    assert "\n" not in str(error.value)


@given(st.text(max_size=40))
def test_any_text_is_an_address_or_is_explained(text: str) -> None:
    try:
        parse(text)
    except ConfigError as error:
        assert "expected" in str(error)
