"""What other tools need: C headers, and a dissector for Wireshark.

Both are made of one dialect: ours, and those messages of the common one that a payload says or hears. All of the common
dialect would be more than a megabyte.
"""

from __future__ import annotations

import re
import textwrap
from collections.abc import Callable
from pathlib import Path
from xml.etree import ElementTree

from pymavlink.dialects import v20
from pymavlink.generator import mavparse

HERE = Path(__file__).resolve().parent
MESSAGES = """
    HEARTBEAT STATUSTEXT NAMED_VALUE_FLOAT DEBUG_FLOAT_ARRAY TUNNEL ONBOARD_COMPUTER_STATUS AUTOPILOT_VERSION
    COMMAND_LONG COMMAND_INT COMMAND_ACK MESSAGE_INTERVAL FILE_TRANSFER_PROTOCOL
    PARAM_REQUEST_READ PARAM_REQUEST_LIST PARAM_VALUE PARAM_SET PARAM_ERROR
    GIMBAL_MANAGER_INFORMATION GIMBAL_MANAGER_STATUS GIMBAL_MANAGER_SET_PITCHYAW
    GIMBAL_DEVICE_INFORMATION GIMBAL_DEVICE_SET_ATTITUDE GIMBAL_DEVICE_ATTITUDE_STATUS
    AUTOPILOT_STATE_FOR_GIMBAL_DEVICE ATTITUDE GLOBAL_POSITION_INT SYSTEM_TIME
    ATTITUDE_QUATERNION LOCAL_POSITION_NED SET_POSITION_TARGET_LOCAL_NED EXTENDED_SYS_STATE RC_CHANNELS MANUAL_CONTROL
    GIMBAL_MANAGER_SET_ATTITUDE RADIO_STATUS
    ESC_STATUS RPM ESC_TELEMETRY_1_TO_4 ESC_TELEMETRY_5_TO_8 ESC_TELEMETRY_9_TO_12
    """
COMMANDS = frozenset({"MAV_CMD_GET_MESSAGE_INTERVAL", "MAV_CMD_SET_MESSAGE_INTERVAL", "MAV_CMD_REQUEST_MESSAGE"})

ENUMS = {"MAV_COMPONENT", "MAV_FTP_OPCODE", "MAV_RESULT"}  # that the dissector looks up, whoever names them

UNKNOWN = """\
        if (fn == nil) then
            pinfo.cols.info:append ("Unknown message type   ")
            subtree:add_expert_info(PI_MALFORMED, PI_ERROR, "Unknown message type")
            size = buffer:len() - 2 - offset
"""
ANOTHER = """\
        if (fn == nil) then
            pinfo.cols.info:append ("   message "..tostring(msgid))
            subtree:add_expert_info(PI_UNDECODED, PI_NOTE, "A message of another dialect")
            size = limit - offset
"""  # and what follows it in its datagram is read
TIME = "    if value > time_usec_threshold then\n"
WHOLE_TIME = '    if type(value) ~= "number" and value > time_usec_threshold then\n'  # a delay is a number of us, too
HEADER = "        local msgid\n        local length\n        local incompatibility_flag\n\n"
WHOLE_FRAME = (
    HEADER
    + """\
        local here = buffer:len() - offset
        local least = version == 0xfd and 12 or 8
        if here < least or here < least + buffer(offset + 1, 1):uint() then
            subtree:add_expert_info(PI_UNDECODED, PI_NOTE, "The rest of this frame is not here")
            break
        end

"""
)  # what is not there, as of a frame in two TCP segments, is not zero
FIELDS = re.compile(
    r"""f\.(\w+)_0 = ProtoField\.new\("(\w+)\[0\] (.*)", "mavlink_proto\.\1_0", (.*)\)\n"""
    r"""((?:f\.\1_\d+ = ProtoField\.new\("\2\[\d+\] \3", "mavlink_proto\.\1_\d+", \4\)\n)+)"""
)  # of an array, one line each
READS = re.compile(
    r"""    tvbrange = padded\(offset \+ (\d+), (\d+)\)\n    subtree = tree:add_le\(f\.(\w+)_0, tvbrange\)\n"""
    r"""((?:    value = .*\n    subtree:append_text\(.*\)\n)?)"""
    r"""((?:    tvbrange = padded\(offset \+ \d+, \2\)\n    subtree = tree:add_le\(f\.\3_\d+, tvbrange\)\n\4)+)"""
)  # of an array, some lines each
BIND = "-- bind protocol dissector to USER0 linktype"
INNER = """\
-- what a TUNNEL of type ROSS_TUNNEL_TYPE_FRAME carries is a frame too
local dissect_tunnel = payload_fns.payload_{id}
payload_fns.payload_{id} = function (buffer, tree, msgid, offset, limit, pinfo)
    local bytes = buffer:range(offset, limit - offset):bytes()
    bytes:set_size({size})
    local whole = bytes:tvb("TUNNEL")
    local length = whole:range({length_at}, 1):uint()
    if whole:range({type_at}, 2):le_uint() ~= {type} or length == 0 or length > {size} - {payload_at} then
        return dissect_tunnel(buffer, tree, msgid, offset, limit, pinfo)
    end
    tree:add_le(f.TUNNEL_payload_type, whole:range({type_at}, 2))
    tree:add_le(f.TUNNEL_target_system, whole:range({system_at}, 1))
    tree:add_le(f.TUNNEL_target_component, whole:range({component_at}, 1))
    tree:add_le(f.TUNNEL_payload_length, whole:range({length_at}, 1))
    mavlink_proto.dissector(bytes:subset({payload_at}, length):tvb("Frame in the TUNNEL"), pinfo, tree)
    pinfo.cols.info:prepend("TUNNEL: ")
end

-- MAVLink 2 on any UDP port is known by its first frame
mavlink_proto:register_heuristic("udp", function (buffer, pinfo, tree)
    if buffer:len() < 12 or buffer:range(0, 1):uint() ~= 0xfd or buffer:range(2, 1):uint() > 1 then
        return false
    end
    local size = 12 + buffer:range(1, 1):uint() + 13 * buffer:range(2, 1):uint()
    if size > buffer:len() or messageName[buffer:range(7, 3):le_uint()] == nil then
        return false
    end
    mavlink_proto.dissector(buffer, pinfo, tree)
    return true
end)

"""


def c_headers(folder: Path, mavgen: Callable[[str, Path, Path], None]) -> None:
    """Write ``mavlink.h`` and what it needs to ``folder/ross``, and the parts of every dialect beside it."""
    folder.mkdir(parents=True, exist_ok=True)
    mavgen("C", folder, _spoken(folder))


def dissector(folder: Path, mavgen: Callable[[str, Path, Path], None]) -> None:
    """Write ``ross.lua``: the generated dissector, which also looks into TUNNEL and past what it does not know."""
    path, xml = folder / "ross.lua", _spoken(folder)
    mavgen("WLua", path, xml)
    tunnel = next(each for each in mavparse.MAVXML(str(xml), mavparse.PROTOCOL_2_0).message if each.name == "TUNNEL")
    places = {name.rpartition("_")[2] + "_at": place for name, place in tunnel.field_offsets.items()}
    inner = INNER.format(id=tunnel.id, size=tunnel.wire_length, type=54000, **places)
    lines = "".join(f"{line.rstrip()}\n" for line in path.read_text(encoding="utf-8").rstrip().splitlines())
    for found in (UNKNOWN, BIND, TIME, HEADER):
        if lines.count(found) != 1:
            raise SystemExit(f"mavgen's dissector has changed: expected exactly once\n{found}")
    lines = (
        lines.replace(UNKNOWN, ANOTHER)
        .replace(BIND, inner + BIND)
        .replace(TIME, WHOLE_TIME)
        .replace(HEADER, WHOLE_FRAME)
    )
    path.write_text(READS.sub(_read, FIELDS.sub(_field, lines)), encoding="utf-8")
    xml.unlink()


def _field(match: re.Match[str]) -> str:
    """Declare an array in a loop."""
    name, label, kind, rest, more = match.groups()
    new = f'ProtoField.new("{label}["..i.."] {kind}", "mavlink_proto.{name}_"..i, {rest})'
    return f'for i = 0, {more.count("ProtoField.new")} do\n    f["{name}_"..i] = {new}\nend\n'


def _read(match: re.Match[str]) -> str:
    """Read an array in a loop."""
    place, size, name, unit, more = match.groups()
    return (
        f"    for i = 0, {more.count('padded(')} do\n"
        f"        tvbrange = padded(offset + {place} + {size} * i, {size})\n"
        f'        subtree = tree:add_le(f["{name}_"..i], tvbrange)\n'
        f"{textwrap.indent(unit, '    ')}    end\n"
    )


def _spoken(folder: Path) -> Path:
    """Write the one dialect, ``ross.xml``; return its path."""
    root = ElementTree.parse(HERE / "mavlink" / "ross.xml").getroot()  # noqa: S314
    enums, messages = _part(root, "enums"), _part(root, "messages")
    tunnels = _enum(enums, "ROSS_TUNNEL_TYPE")
    enums.remove(tunnels)
    messages.extend(_part(ElementTree.parse(HERE / "mavlink" / "standard.xml").getroot(), "messages"))  # noqa: S314
    common = _common()
    messages.extend(each for part in common for each in part.iter("message") if each.get("name") in MESSAGES.split())
    strangers = {str(each.get("name")): each for part in common for each in part.iter("enum")}
    _enum(enums, "MAV_CMD").extend(each for each in strangers["MAV_CMD"] if each.get("name") in COMMANDS)
    wanted = ENUMS | {str(each.get("enum")) for each in root.iter() if each.get("enum")}
    enums.extend(each for name, each in strangers.items() if name in wanted - {"MAV_CMD"})
    _enum(enums, "MAV_TUNNEL_PAYLOAD_TYPE").extend(tunnels.iter("entry"))
    path = folder / "ross.xml"
    ElementTree.ElementTree(root).write(path, encoding="utf-8", xml_declaration=True)
    return path


def _common() -> list[ElementTree.Element]:
    """Return MAVLink's common dialect as pymavlink brings it."""
    folder = Path(v20.__file__).parent
    return [ElementTree.parse(folder / f"{name}.xml").getroot() for name in ("minimal", "standard", "common")]  # noqa: S314


def _part(root: ElementTree.Element, name: str) -> ElementTree.Element:
    part = root.find(name)
    return ElementTree.SubElement(root, name) if part is None else part


def _enum(enums: ElementTree.Element, name: str) -> ElementTree.Element:
    return next(each for each in enums if each.get("name") == name)
