"""What CANopen's numbers say: emergencies (CiA 301, CiA 402) and refusals of a read or write (CiA 301)."""

from __future__ import annotations

EMERGENCIES = {
    0x0000: "no error",
    0x1000: "generic error",
    0x2000: "current",
    0x2100: "current on the input side",
    0x2200: "current inside the device",
    0x2300: "current on the output side",
    0x2310: "continuous overcurrent",
    0x2320: "short circuit or earth leakage",
    0x2330: "earth leakage",
    0x2340: "short circuit",
    0x2350: "load level of the motor (I2t)",
    0x3000: "voltage",
    0x3100: "mains voltage",
    0x3200: "voltage inside the device",
    0x3210: "overvoltage in the DC link",
    0x3220: "undervoltage in the DC link",
    0x3300: "output voltage",
    0x4000: "temperature",
    0x4100: "ambient temperature",
    0x4200: "device temperature",
    0x4210: "device too hot",
    0x4300: "temperature of the drive",
    0x4310: "drive too hot",
    0x5000: "device hardware",
    0x5100: "supply",
    0x5113: "5 V supply low",
    0x5200: "control hardware",
    0x5400: "power section",
    0x5441: "contacts of the safety input (STO)",
    0x5500: "data storage",
    0x6000: "device software",
    0x6100: "internal software",
    0x6200: "user software",
    0x6300: "data set",
    0x6320: "a parameter is wrong",
    0x7000: "additional modules",
    0x7100: "power module",
    0x7110: "brake chopper",
    0x7121: "motor blocked",
    0x7122: "motor error or commutation",
    0x7300: "sensor",
    0x7303: "resolver fault",
    0x7305: "incremental encoder fault",
    0x7310: "speed sensor",
    0x7320: "position sensor",
    0x7380: "encoder signals",
    0x7500: "communication module",
    0x8000: "monitoring",
    0x8100: "communication",
    0x8110: "CAN overrun: frames lost",
    0x8120: "CAN error passive",
    0x8130: "heartbeat or life guard missed",
    0x8140: "recovered from bus off",
    0x8150: "CAN identifier collision",
    0x8200: "protocol",
    0x8210: "process data too short",
    0x8220: "process data too long",
    0x8300: "torque control",
    0x8400: "velocity control",
    0x8480: "speed limit exceeded",
    0x8500: "position control",
    0x8600: "positioning",
    0x8611: "following error",
    0x8612: "reference limit: a limit switch or a software limit",
    0x8613: "homing error",
    0x8700: "synchronisation",
    0x8A00: "motion",
    0x9000: "external error",
    0xF000: "additional functions",
    0xFF00: "device specific",
}

ABORTS = {
    0x05030000: "toggle bit not alternated",
    0x05040000: "the protocol timed out",
    0x05040001: "unknown command",
    0x05040005: "out of memory",
    0x06010000: "access not supported",
    0x06010001: "it can only be written",
    0x06010002: "it can only be read",
    0x06020000: "no such object",
    0x06040041: "it cannot be mapped to process data",
    0x06040042: "too much for one process data frame",
    0x06040043: "parameters do not fit together",
    0x06040047: "internal incompatibility",
    0x06060000: "hardware error",
    0x06070010: "wrong length",
    0x06070012: "too long",
    0x06070013: "too short",
    0x06090011: "no such subindex",
    0x06090030: "value out of range",
    0x06090031: "value too high",
    0x06090032: "value too low",
    0x06090036: "maximum below minimum",
    0x08000000: "general error",
    0x08000020: "data cannot be stored",
    0x08000021: "data cannot be stored: local control",
    0x08000022: "data cannot be stored in this state",
    0x08000023: "no object dictionary",
    0x08000024: "no data",
}


def emergency_words(code: int) -> str:
    """Say what an emergency means: the code, else its group, else its class.

    >>> emergency_words(0x8611), emergency_words(0x3299), emergency_words(0x3999)
    ('following error', 'voltage inside the device', 'voltage')
    """
    groups = (code, code & 0xFFF0, code & 0xFF00, code & 0xF000)
    return next(
        (EMERGENCIES[group] for group in groups if group in EMERGENCIES and (group or not code)), "unknown error"
    )


def abort_words(code: int) -> str:
    """Say why a read or write was refused.

    >>> abort_words(0x06020000), abort_words(1)
    ('no such object', 'abort 0x00000001')
    """
    return ABORTS.get(code, f"abort 0x{code:08X}")
