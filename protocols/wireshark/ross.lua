-- Wireshark dissector for the MAVLink protocol (please see https://mavlink.io/en for details)

unknownFrameBeginOffset = 0
mavlink_proto = Proto("mavlink_proto", "MAVLink protocol")
f = mavlink_proto.fields

-- from http://lua-users.org/wiki/TimeZone
local function get_timezone()
    local now = os.time()
    return os.difftime(now, os.time(os.date("!*t", now)))
end
local signature_time_ref = get_timezone() + os.time{year=2015, month=1, day=1, hour=0}

-- threshold to decide if time is absolute or relative (some time in 2005)
time_usec_threshold = UInt64.new(0,0x40000)
-- function to append human-readable time onto unix_time_us fields
local function time_usec_decode(value)
    if type(value) ~= "number" and value > time_usec_threshold then
        s = math.floor(value:tonumber() / 1000000.0)
        us = value % 1000000
        d = os.date("%Y-%m-%d %H:%M:%S",s)
        us = string.format("%06d",us:tonumber())
        ok, tz = pcall(os.date," %Z",s)
        if not ok then
            tz = os.date(" %z",s)
        end
        return " (" .. d .. "." .. us .. tz .. ")"
    elseif value < 1000000 then
        return ""
    elseif type(value) == "number" then
        return string.format(" (%.6f s)",value / 1000000.0)
    else
        return string.format(" (%.6f s)",value:tonumber() / 1000000.0)
    end
end

payload_fns = {}

protocolVersions = {
    [0xfd] = "MAVLink 2.0",
    [0xfe] = "MAVLink 1.0"
}

messageName = {
    [54000] = 'ROSS_INFORMATION',
    [54001] = 'ROSS_STATUS',
    [54002] = 'ROSS_SOURCE',
    [54003] = 'ROSS_ALIGNMENT',
    [54004] = 'ROSS_SEPARATION',
    [54005] = 'ROSS_AUDIO',
    [54006] = 'ROSS_RECORDING',
    [54007] = 'ROSS_DENSITY',
    [54008] = 'ROSS_ISOLATION',
    [54009] = 'ROSS_LINK',
    [54010] = 'ROSS_STREAM',
    [80] = 'COMMAND_CANCEL',
    [111] = 'TIMESYNC',
    [226] = 'RPM',
    [291] = 'ESC_STATUS',
    [300] = 'PROTOCOL_VERSION',
    [396] = 'COMPONENT_INFORMATION_BASIC',
    [397] = 'COMPONENT_METADATA',
    [436] = 'CURRENT_MODE',
    [11030] = 'ESC_TELEMETRY_1_TO_4',
    [11031] = 'ESC_TELEMETRY_5_TO_8',
    [11032] = 'ESC_TELEMETRY_9_TO_12',
    [0] = 'HEARTBEAT',
    [33] = 'GLOBAL_POSITION_INT',
    [148] = 'AUTOPILOT_VERSION',
    [2] = 'SYSTEM_TIME',
    [20] = 'PARAM_REQUEST_READ',
    [21] = 'PARAM_REQUEST_LIST',
    [22] = 'PARAM_VALUE',
    [23] = 'PARAM_SET',
    [30] = 'ATTITUDE',
    [31] = 'ATTITUDE_QUATERNION',
    [32] = 'LOCAL_POSITION_NED',
    [65] = 'RC_CHANNELS',
    [69] = 'MANUAL_CONTROL',
    [75] = 'COMMAND_INT',
    [76] = 'COMMAND_LONG',
    [77] = 'COMMAND_ACK',
    [84] = 'SET_POSITION_TARGET_LOCAL_NED',
    [109] = 'RADIO_STATUS',
    [110] = 'FILE_TRANSFER_PROTOCOL',
    [244] = 'MESSAGE_INTERVAL',
    [245] = 'EXTENDED_SYS_STATE',
    [251] = 'NAMED_VALUE_FLOAT',
    [253] = 'STATUSTEXT',
    [280] = 'GIMBAL_MANAGER_INFORMATION',
    [281] = 'GIMBAL_MANAGER_STATUS',
    [282] = 'GIMBAL_MANAGER_SET_ATTITUDE',
    [283] = 'GIMBAL_DEVICE_INFORMATION',
    [284] = 'GIMBAL_DEVICE_SET_ATTITUDE',
    [285] = 'GIMBAL_DEVICE_ATTITUDE_STATUS',
    [286] = 'AUTOPILOT_STATE_FOR_GIMBAL_DEVICE',
    [287] = 'GIMBAL_MANAGER_SET_PITCHYAW',
    [345] = 'PARAM_ERROR',
    [350] = 'DEBUG_FLOAT_ARRAY',
    [385] = 'TUNNEL',
    [390] = 'ONBOARD_COMPUTER_STATUS',
}

local enumEntryName = {
    ["ROSS_STATE"] = {
        [0] = "ROSS_STATE_IDLE",
        [1] = "ROSS_STATE_LEAD_IN",
        [2] = "ROSS_STATE_EXPLORE_TURN",
        [3] = "ROSS_STATE_EXPLORE_LISTEN",
        [4] = "ROSS_STATE_ALIGN_TURN",
        [5] = "ROSS_STATE_CHECK",
        [6] = "ROSS_STATE_RUN",
        [7] = "ROSS_STATE_DONE",
        [8] = "ROSS_STATE_STOPPED",
        [9] = "ROSS_STATE_FAULT",
        [10] = "ROSS_STATE_TURN",
        [11] = "ROSS_STATE_NOISE",
    },
    ["ROSS_OUTCOME"] = {
        [0] = "ROSS_OUTCOME_TARGET_FOUND",
        [1] = "ROSS_OUTCOME_FAULT",
        [3] = "ROSS_OUTCOME_NO_TARGET",
        [4] = "ROSS_OUTCOME_COMPLETED",
        [130] = "ROSS_OUTCOME_STOPPED",
    },
    ["ROSS_FRAME"] = {
        [1] = "ROSS_FRAME_EARTH",
        [2] = "ROSS_FRAME_MOUNT",
    },
    ["ROSS_STATUS_FLAGS"] = {
        [1] = "ROSS_STATUS_FLAGS_NOISE_MEASURED",
        [2] = "ROSS_STATUS_FLAGS_CERTAIN",
        [4] = "ROSS_STATUS_FLAGS_TARGET_FOUND",
        [8] = "ROSS_STATUS_FLAGS_TIME_UNIX",
        [16] = "ROSS_STATUS_FLAGS_STREAMING",
        [32] = "ROSS_STATUS_FLAGS_RECORDING",
    },
    ["ROSS_ACTUATOR_FLAGS"] = {
        [1] = "ROSS_ACTUATOR_FLAGS_PRESENT",
        [2] = "ROSS_ACTUATOR_FLAGS_SETTLED",
        [4] = "ROSS_ACTUATOR_FLAGS_HOMED",
        [8] = "ROSS_ACTUATOR_FLAGS_FAULT",
        [16] = "ROSS_ACTUATOR_FLAGS_OPEN_LOOP",
    },
    ["ROSS_SOURCE_FLAGS"] = {
        [1] = "ROSS_SOURCE_FLAGS_RESOLVED",
        [2] = "ROSS_SOURCE_FLAGS_TARGET",
        [4] = "ROSS_SOURCE_FLAGS_FINAL",
        [8] = "ROSS_SOURCE_FLAGS_TRACKED",
    },
    ["ROSS_ALIGNMENT_RULE"] = {
        [0] = "ROSS_ALIGNMENT_RULE_UNKNOWN",
        [1] = "ROSS_ALIGNMENT_RULE_BISECTOR",
        [2] = "ROSS_ALIGNMENT_RULE_ARGMAX",
        [3] = "ROSS_ALIGNMENT_RULE_STAY",
        [4] = "ROSS_ALIGNMENT_RULE_GAIN",
        [5] = "ROSS_ALIGNMENT_RULE_LIMITED",
    },
    ["ROSS_CANDIDATE_STATE"] = {
        [0] = "ROSS_CANDIDATE_STATE_PLANNED",
        [1] = "ROSS_CANDIDATE_STATE_TURNING",
        [2] = "ROSS_CANDIDATE_STATE_REJECTED",
        [3] = "ROSS_CANDIDATE_STATE_ACCEPTED",
    },
    ["ROSS_SEPARATION_PHASE"] = {
        [1] = "ROSS_SEPARATION_PHASE_CHECK",
        [2] = "ROSS_SEPARATION_PHASE_RUN",
    },
    ["ROSS_GROUP_FLAGS"] = {
        [1] = "ROSS_GROUP_FLAGS_ACCEPTED",
        [2] = "ROSS_GROUP_FLAGS_TARGET",
    },
    ["ROSS_AUDIO_TROUBLE"] = {
        [1] = "ROSS_AUDIO_TROUBLE_CLIPPING",
        [2] = "ROSS_AUDIO_TROUBLE_DEAD_1",
        [4] = "ROSS_AUDIO_TROUBLE_DEAD_2",
        [8] = "ROSS_AUDIO_TROUBLE_OFFSET",
        [16] = "ROSS_AUDIO_TROUBLE_IDENTICAL",
        [32] = "ROSS_AUDIO_TROUBLE_INVERTED",
        [64] = "ROSS_AUDIO_TROUBLE_LOST",
        [128] = "ROSS_AUDIO_TROUBLE_ABSENT",
    },
    ["ROSS_RECORDING_STATE"] = {
        [0] = "ROSS_RECORDING_STATE_OFF",
        [1] = "ROSS_RECORDING_STATE_ON",
        [2] = "ROSS_RECORDING_STATE_FULL",
        [3] = "ROSS_RECORDING_STATE_BROKEN",
    },
    ["ROSS_SELECTION"] = {
        [0] = "ROSS_SELECTION_NONE",
        [1] = "ROSS_SELECTION_MIXTURE",
        [2] = "ROSS_SELECTION_TARGET",
        [3] = "ROSS_SELECTION_SOURCE",
        [4] = "ROSS_SELECTION_AZIMUTH",
    },
    ["ROSS_CODEC"] = {
        [0] = "ROSS_CODEC_OTHER",
        [1] = "ROSS_CODEC_L16",
        [2] = "ROSS_CODEC_OPUS",
        [3] = "ROSS_CODEC_PCM",
        [4] = "ROSS_CODEC_FLAC",
    },
    ["ROSS_STREAM_FLAGS"] = {
        [1] = "ROSS_STREAM_FLAGS_ON",
        [2] = "ROSS_STREAM_FLAGS_FAULT",
        [4] = "ROSS_STREAM_FLAGS_MUTED",
        [8] = "ROSS_STREAM_FLAGS_RECORDS",
        [16] = "ROSS_STREAM_FLAGS_SEPARATED",
    },
    ["ROSS_LINK_FLAGS"] = {
        [1] = "ROSS_LINK_FLAGS_UP",
        [2] = "ROSS_LINK_FLAGS_AUTOPILOT",
    },
    ["ROSS_LISTEN_MODE"] = {
        [0] = "ROSS_LISTEN_MODE_VOICE",
        [1] = "ROSS_LISTEN_MODE_SOURCE",
        [2] = "ROSS_LISTEN_MODE_AZIMUTH",
    },
    ["MAV_CMD"] = {
        [510] = "MAV_CMD_GET_MESSAGE_INTERVAL",
        [511] = "MAV_CMD_SET_MESSAGE_INTERVAL",
        [512] = "MAV_CMD_REQUEST_MESSAGE",
        [54000] = "MAV_CMD_ROSS_EXPLORE",
        [54001] = "MAV_CMD_ROSS_LISTEN",
        [54002] = "MAV_CMD_ROSS_INFORM",
        [54003] = "MAV_CMD_ROSS_TURN",
        [54004] = "MAV_CMD_ROSS_STOP",
        [54005] = "MAV_CMD_ROSS_CANCEL",
        [54006] = "MAV_CMD_ROSS_PARK",
        [54007] = "MAV_CMD_ROSS_MEASURE_NOISE",
        [54008] = "MAV_CMD_ROSS_RECORD",
        [54009] = "MAV_CMD_ROSS_REARM",
        [54010] = "MAV_CMD_ROSS_HOME",
        [54011] = "MAV_CMD_ROSS_STREAM",
        [54012] = "MAV_CMD_ROSS_ENROL",
    },
    ["MAV_AUTOPILOT"] = {
        [0] = "MAV_AUTOPILOT_GENERIC",
        [1] = "MAV_AUTOPILOT_RESERVED",
        [2] = "MAV_AUTOPILOT_SLUGS",
        [3] = "MAV_AUTOPILOT_ARDUPILOTMEGA",
        [4] = "MAV_AUTOPILOT_OPENPILOT",
        [5] = "MAV_AUTOPILOT_GENERIC_WAYPOINTS_ONLY",
        [6] = "MAV_AUTOPILOT_GENERIC_WAYPOINTS_AND_SIMPLE_NAVIGATION_ONLY",
        [7] = "MAV_AUTOPILOT_GENERIC_MISSION_FULL",
        [8] = "MAV_AUTOPILOT_INVALID",
        [9] = "MAV_AUTOPILOT_PPZ",
        [10] = "MAV_AUTOPILOT_UDB",
        [11] = "MAV_AUTOPILOT_FP",
        [12] = "MAV_AUTOPILOT_PX4",
        [13] = "MAV_AUTOPILOT_SMACCMPILOT",
        [14] = "MAV_AUTOPILOT_AUTOQUAD",
        [15] = "MAV_AUTOPILOT_ARMAZILA",
        [16] = "MAV_AUTOPILOT_AEROB",
        [17] = "MAV_AUTOPILOT_ASLUAV",
        [18] = "MAV_AUTOPILOT_SMARTAP",
        [19] = "MAV_AUTOPILOT_AIRRAILS",
        [20] = "MAV_AUTOPILOT_REFLEX",
    },
    ["MAV_TYPE"] = {
        [0] = "MAV_TYPE_GENERIC",
        [1] = "MAV_TYPE_FIXED_WING",
        [2] = "MAV_TYPE_QUADROTOR",
        [3] = "MAV_TYPE_COAXIAL",
        [4] = "MAV_TYPE_HELICOPTER",
        [5] = "MAV_TYPE_ANTENNA_TRACKER",
        [6] = "MAV_TYPE_GCS",
        [7] = "MAV_TYPE_AIRSHIP",
        [8] = "MAV_TYPE_FREE_BALLOON",
        [9] = "MAV_TYPE_ROCKET",
        [10] = "MAV_TYPE_GROUND_ROVER",
        [11] = "MAV_TYPE_SURFACE_BOAT",
        [12] = "MAV_TYPE_SUBMARINE",
        [13] = "MAV_TYPE_HEXAROTOR",
        [14] = "MAV_TYPE_OCTOROTOR",
        [15] = "MAV_TYPE_TRICOPTER",
        [16] = "MAV_TYPE_FLAPPING_WING",
        [17] = "MAV_TYPE_KITE",
        [18] = "MAV_TYPE_ONBOARD_CONTROLLER",
        [19] = "MAV_TYPE_VTOL_DUOROTOR",
        [20] = "MAV_TYPE_VTOL_QUADROTOR",
        [21] = "MAV_TYPE_VTOL_TILTROTOR",
        [22] = "MAV_TYPE_VTOL_RESERVED2",
        [23] = "MAV_TYPE_VTOL_RESERVED3",
        [24] = "MAV_TYPE_VTOL_RESERVED4",
        [25] = "MAV_TYPE_VTOL_RESERVED5",
        [26] = "MAV_TYPE_GIMBAL",
        [27] = "MAV_TYPE_ADSB",
        [28] = "MAV_TYPE_PARAFOIL",
        [29] = "MAV_TYPE_DODECAROTOR",
        [30] = "MAV_TYPE_CAMERA",
        [31] = "MAV_TYPE_CHARGING_STATION",
        [32] = "MAV_TYPE_FLARM",
        [33] = "MAV_TYPE_SERVO",
        [34] = "MAV_TYPE_ODID",
        [35] = "MAV_TYPE_DECAROTOR",
        [36] = "MAV_TYPE_BATTERY",
        [37] = "MAV_TYPE_PARACHUTE",
        [38] = "MAV_TYPE_LOG",
        [39] = "MAV_TYPE_OSD",
        [40] = "MAV_TYPE_IMU",
        [41] = "MAV_TYPE_GPS",
        [42] = "MAV_TYPE_WINCH",
        [43] = "MAV_TYPE_GENERIC_MULTIROTOR",
        [44] = "MAV_TYPE_ILLUMINATOR",
        [45] = "MAV_TYPE_SPACECRAFT_ORBITER",
        [46] = "MAV_TYPE_GROUND_QUADRUPED",
        [47] = "MAV_TYPE_VTOL_GYRODYNE",
        [48] = "MAV_TYPE_GRIPPER",
    },
    ["MAV_MODE_FLAG"] = {
        [1] = "MAV_MODE_FLAG_CUSTOM_MODE_ENABLED",
        [2] = "MAV_MODE_FLAG_TEST_ENABLED",
        [4] = "MAV_MODE_FLAG_AUTO_ENABLED",
        [8] = "MAV_MODE_FLAG_GUIDED_ENABLED",
        [16] = "MAV_MODE_FLAG_STABILIZE_ENABLED",
        [32] = "MAV_MODE_FLAG_HIL_ENABLED",
        [64] = "MAV_MODE_FLAG_MANUAL_INPUT_ENABLED",
        [128] = "MAV_MODE_FLAG_SAFETY_ARMED",
    },
    ["MAV_STATE"] = {
        [0] = "MAV_STATE_UNINIT",
        [1] = "MAV_STATE_BOOT",
        [2] = "MAV_STATE_CALIBRATING",
        [3] = "MAV_STATE_STANDBY",
        [4] = "MAV_STATE_ACTIVE",
        [5] = "MAV_STATE_CRITICAL",
        [6] = "MAV_STATE_EMERGENCY",
        [7] = "MAV_STATE_POWEROFF",
        [8] = "MAV_STATE_FLIGHT_TERMINATION",
    },
    ["MAV_COMPONENT"] = {
        [0] = "MAV_COMP_ID_ALL",
        [1] = "MAV_COMP_ID_AUTOPILOT1",
        [25] = "MAV_COMP_ID_USER1",
        [26] = "MAV_COMP_ID_USER2",
        [27] = "MAV_COMP_ID_USER3",
        [28] = "MAV_COMP_ID_USER4",
        [29] = "MAV_COMP_ID_USER5",
        [30] = "MAV_COMP_ID_USER6",
        [31] = "MAV_COMP_ID_USER7",
        [32] = "MAV_COMP_ID_USER8",
        [33] = "MAV_COMP_ID_USER9",
        [34] = "MAV_COMP_ID_USER10",
        [35] = "MAV_COMP_ID_USER11",
        [36] = "MAV_COMP_ID_USER12",
        [37] = "MAV_COMP_ID_USER13",
        [38] = "MAV_COMP_ID_USER14",
        [39] = "MAV_COMP_ID_USER15",
        [40] = "MAV_COMP_ID_USER16",
        [41] = "MAV_COMP_ID_USER17",
        [42] = "MAV_COMP_ID_USER18",
        [43] = "MAV_COMP_ID_USER19",
        [44] = "MAV_COMP_ID_USER20",
        [45] = "MAV_COMP_ID_USER21",
        [46] = "MAV_COMP_ID_USER22",
        [47] = "MAV_COMP_ID_USER23",
        [48] = "MAV_COMP_ID_USER24",
        [49] = "MAV_COMP_ID_USER25",
        [50] = "MAV_COMP_ID_USER26",
        [51] = "MAV_COMP_ID_USER27",
        [52] = "MAV_COMP_ID_USER28",
        [53] = "MAV_COMP_ID_USER29",
        [54] = "MAV_COMP_ID_USER30",
        [55] = "MAV_COMP_ID_USER31",
        [56] = "MAV_COMP_ID_USER32",
        [57] = "MAV_COMP_ID_USER33",
        [58] = "MAV_COMP_ID_USER34",
        [59] = "MAV_COMP_ID_USER35",
        [60] = "MAV_COMP_ID_USER36",
        [61] = "MAV_COMP_ID_USER37",
        [62] = "MAV_COMP_ID_USER38",
        [63] = "MAV_COMP_ID_USER39",
        [64] = "MAV_COMP_ID_USER40",
        [65] = "MAV_COMP_ID_USER41",
        [66] = "MAV_COMP_ID_USER42",
        [67] = "MAV_COMP_ID_USER43",
        [68] = "MAV_COMP_ID_TELEMETRY_RADIO",
        [69] = "MAV_COMP_ID_USER45",
        [70] = "MAV_COMP_ID_USER46",
        [71] = "MAV_COMP_ID_USER47",
        [72] = "MAV_COMP_ID_USER48",
        [73] = "MAV_COMP_ID_USER49",
        [74] = "MAV_COMP_ID_USER50",
        [75] = "MAV_COMP_ID_USER51",
        [76] = "MAV_COMP_ID_USER52",
        [77] = "MAV_COMP_ID_USER53",
        [78] = "MAV_COMP_ID_USER54",
        [79] = "MAV_COMP_ID_USER55",
        [80] = "MAV_COMP_ID_USER56",
        [81] = "MAV_COMP_ID_USER57",
        [82] = "MAV_COMP_ID_USER58",
        [83] = "MAV_COMP_ID_USER59",
        [84] = "MAV_COMP_ID_USER60",
        [85] = "MAV_COMP_ID_USER61",
        [86] = "MAV_COMP_ID_USER62",
        [87] = "MAV_COMP_ID_USER63",
        [88] = "MAV_COMP_ID_USER64",
        [89] = "MAV_COMP_ID_USER65",
        [90] = "MAV_COMP_ID_USER66",
        [91] = "MAV_COMP_ID_USER67",
        [92] = "MAV_COMP_ID_USER68",
        [93] = "MAV_COMP_ID_USER69",
        [94] = "MAV_COMP_ID_USER70",
        [95] = "MAV_COMP_ID_USER71",
        [96] = "MAV_COMP_ID_USER72",
        [97] = "MAV_COMP_ID_USER73",
        [98] = "MAV_COMP_ID_USER74",
        [99] = "MAV_COMP_ID_USER75",
        [100] = "MAV_COMP_ID_CAMERA",
        [101] = "MAV_COMP_ID_CAMERA2",
        [102] = "MAV_COMP_ID_CAMERA3",
        [103] = "MAV_COMP_ID_CAMERA4",
        [104] = "MAV_COMP_ID_CAMERA5",
        [105] = "MAV_COMP_ID_CAMERA6",
        [140] = "MAV_COMP_ID_SERVO1",
        [141] = "MAV_COMP_ID_SERVO2",
        [142] = "MAV_COMP_ID_SERVO3",
        [143] = "MAV_COMP_ID_SERVO4",
        [144] = "MAV_COMP_ID_SERVO5",
        [145] = "MAV_COMP_ID_SERVO6",
        [146] = "MAV_COMP_ID_SERVO7",
        [147] = "MAV_COMP_ID_SERVO8",
        [148] = "MAV_COMP_ID_SERVO9",
        [149] = "MAV_COMP_ID_SERVO10",
        [150] = "MAV_COMP_ID_SERVO11",
        [151] = "MAV_COMP_ID_SERVO12",
        [152] = "MAV_COMP_ID_SERVO13",
        [153] = "MAV_COMP_ID_SERVO14",
        [154] = "MAV_COMP_ID_GIMBAL",
        [155] = "MAV_COMP_ID_LOG",
        [156] = "MAV_COMP_ID_ADSB",
        [157] = "MAV_COMP_ID_OSD",
        [158] = "MAV_COMP_ID_PERIPHERAL",
        [159] = "MAV_COMP_ID_QX1_GIMBAL",
        [160] = "MAV_COMP_ID_FLARM",
        [161] = "MAV_COMP_ID_PARACHUTE",
        [169] = "MAV_COMP_ID_WINCH",
        [171] = "MAV_COMP_ID_GIMBAL2",
        [172] = "MAV_COMP_ID_GIMBAL3",
        [173] = "MAV_COMP_ID_GIMBAL4",
        [174] = "MAV_COMP_ID_GIMBAL5",
        [175] = "MAV_COMP_ID_GIMBAL6",
        [180] = "MAV_COMP_ID_BATTERY",
        [181] = "MAV_COMP_ID_BATTERY2",
        [189] = "MAV_COMP_ID_MAVCAN",
        [190] = "MAV_COMP_ID_MISSIONPLANNER",
        [191] = "MAV_COMP_ID_ONBOARD_COMPUTER",
        [192] = "MAV_COMP_ID_ONBOARD_COMPUTER2",
        [193] = "MAV_COMP_ID_ONBOARD_COMPUTER3",
        [194] = "MAV_COMP_ID_ONBOARD_COMPUTER4",
        [195] = "MAV_COMP_ID_PATHPLANNER",
        [196] = "MAV_COMP_ID_OBSTACLE_AVOIDANCE",
        [197] = "MAV_COMP_ID_VISUAL_INERTIAL_ODOMETRY",
        [198] = "MAV_COMP_ID_PAIRING_MANAGER",
        [200] = "MAV_COMP_ID_IMU",
        [201] = "MAV_COMP_ID_IMU_2",
        [202] = "MAV_COMP_ID_IMU_3",
        [220] = "MAV_COMP_ID_GPS",
        [221] = "MAV_COMP_ID_GPS2",
        [236] = "MAV_COMP_ID_ODID_TXRX_1",
        [237] = "MAV_COMP_ID_ODID_TXRX_2",
        [238] = "MAV_COMP_ID_ODID_TXRX_3",
        [240] = "MAV_COMP_ID_UDP_BRIDGE",
        [241] = "MAV_COMP_ID_UART_BRIDGE",
        [242] = "MAV_COMP_ID_TUNNEL_NODE",
        [243] = "MAV_COMP_ID_ILLUMINATOR",
        [250] = "MAV_COMP_ID_SYSTEM_CONTROL",
    },
    ["MAV_PROTOCOL_CAPABILITY"] = {
        [1] = "MAV_PROTOCOL_CAPABILITY_MISSION_FLOAT",
        [2] = "MAV_PROTOCOL_CAPABILITY_PARAM_FLOAT",
        [4] = "MAV_PROTOCOL_CAPABILITY_MISSION_INT",
        [8] = "MAV_PROTOCOL_CAPABILITY_COMMAND_INT",
        [16] = "MAV_PROTOCOL_CAPABILITY_PARAM_ENCODE_BYTEWISE",
        [32] = "MAV_PROTOCOL_CAPABILITY_FTP",
        [64] = "MAV_PROTOCOL_CAPABILITY_SET_ATTITUDE_TARGET",
        [128] = "MAV_PROTOCOL_CAPABILITY_SET_POSITION_TARGET_LOCAL_NED",
        [256] = "MAV_PROTOCOL_CAPABILITY_SET_POSITION_TARGET_GLOBAL_INT",
        [512] = "MAV_PROTOCOL_CAPABILITY_TERRAIN",
        [1024] = "MAV_PROTOCOL_CAPABILITY_RESERVED3",
        [2048] = "MAV_PROTOCOL_CAPABILITY_FLIGHT_TERMINATION",
        [4096] = "MAV_PROTOCOL_CAPABILITY_COMPASS_CALIBRATION",
        [8192] = "MAV_PROTOCOL_CAPABILITY_MAVLINK2",
        [16384] = "MAV_PROTOCOL_CAPABILITY_MISSION_FENCE",
        [32768] = "MAV_PROTOCOL_CAPABILITY_MISSION_RALLY",
        [65536] = "MAV_PROTOCOL_CAPABILITY_RESERVED2",
        [131072] = "MAV_PROTOCOL_CAPABILITY_PARAM_ENCODE_C_CAST",
        [262144] = "MAV_PROTOCOL_CAPABILITY_COMPONENT_IMPLEMENTS_GIMBAL_MANAGER",
        [524288] = "MAV_PROTOCOL_CAPABILITY_COMPONENT_ACCEPTS_GCS_CONTROL",
        [1048576] = "MAV_PROTOCOL_CAPABILITY_GRIPPER",
    },
    ["MAV_FRAME"] = {
        [0] = "MAV_FRAME_GLOBAL",
        [1] = "MAV_FRAME_LOCAL_NED",
        [2] = "MAV_FRAME_MISSION",
        [3] = "MAV_FRAME_GLOBAL_RELATIVE_ALT",
        [4] = "MAV_FRAME_LOCAL_ENU",
        [5] = "MAV_FRAME_GLOBAL_INT",
        [6] = "MAV_FRAME_GLOBAL_RELATIVE_ALT_INT",
        [7] = "MAV_FRAME_LOCAL_OFFSET_NED",
        [8] = "MAV_FRAME_BODY_NED",
        [9] = "MAV_FRAME_BODY_OFFSET_NED",
        [10] = "MAV_FRAME_GLOBAL_TERRAIN_ALT",
        [11] = "MAV_FRAME_GLOBAL_TERRAIN_ALT_INT",
        [12] = "MAV_FRAME_BODY_FRD",
        [13] = "MAV_FRAME_RESERVED_13",
        [14] = "MAV_FRAME_RESERVED_14",
        [15] = "MAV_FRAME_RESERVED_15",
        [16] = "MAV_FRAME_RESERVED_16",
        [17] = "MAV_FRAME_RESERVED_17",
        [18] = "MAV_FRAME_RESERVED_18",
        [19] = "MAV_FRAME_RESERVED_19",
        [20] = "MAV_FRAME_LOCAL_FRD",
        [21] = "MAV_FRAME_LOCAL_FLU",
    },
    ["GIMBAL_DEVICE_CAP_FLAGS"] = {
        [1] = "GIMBAL_DEVICE_CAP_FLAGS_HAS_RETRACT",
        [2] = "GIMBAL_DEVICE_CAP_FLAGS_HAS_NEUTRAL",
        [4] = "GIMBAL_DEVICE_CAP_FLAGS_HAS_ROLL_AXIS",
        [8] = "GIMBAL_DEVICE_CAP_FLAGS_HAS_ROLL_FOLLOW",
        [16] = "GIMBAL_DEVICE_CAP_FLAGS_HAS_ROLL_LOCK",
        [32] = "GIMBAL_DEVICE_CAP_FLAGS_HAS_PITCH_AXIS",
        [64] = "GIMBAL_DEVICE_CAP_FLAGS_HAS_PITCH_FOLLOW",
        [128] = "GIMBAL_DEVICE_CAP_FLAGS_HAS_PITCH_LOCK",
        [256] = "GIMBAL_DEVICE_CAP_FLAGS_HAS_YAW_AXIS",
        [512] = "GIMBAL_DEVICE_CAP_FLAGS_HAS_YAW_FOLLOW",
        [1024] = "GIMBAL_DEVICE_CAP_FLAGS_HAS_YAW_LOCK",
        [2048] = "GIMBAL_DEVICE_CAP_FLAGS_SUPPORTS_INFINITE_YAW",
        [4096] = "GIMBAL_DEVICE_CAP_FLAGS_SUPPORTS_YAW_IN_EARTH_FRAME",
        [8192] = "GIMBAL_DEVICE_CAP_FLAGS_HAS_RC_INPUTS",
        [65536] = "GIMBAL_DEVICE_CAP_FLAGS_CAN_POINT_LOCATION_LOCAL",
        [131072] = "GIMBAL_DEVICE_CAP_FLAGS_CAN_POINT_LOCATION_GLOBAL",
    },
    ["GIMBAL_MANAGER_CAP_FLAGS"] = {
        [1] = "GIMBAL_MANAGER_CAP_FLAGS_HAS_RETRACT",
        [2] = "GIMBAL_MANAGER_CAP_FLAGS_HAS_NEUTRAL",
        [4] = "GIMBAL_MANAGER_CAP_FLAGS_HAS_ROLL_AXIS",
        [8] = "GIMBAL_MANAGER_CAP_FLAGS_HAS_ROLL_FOLLOW",
        [16] = "GIMBAL_MANAGER_CAP_FLAGS_HAS_ROLL_LOCK",
        [32] = "GIMBAL_MANAGER_CAP_FLAGS_HAS_PITCH_AXIS",
        [64] = "GIMBAL_MANAGER_CAP_FLAGS_HAS_PITCH_FOLLOW",
        [128] = "GIMBAL_MANAGER_CAP_FLAGS_HAS_PITCH_LOCK",
        [256] = "GIMBAL_MANAGER_CAP_FLAGS_HAS_YAW_AXIS",
        [512] = "GIMBAL_MANAGER_CAP_FLAGS_HAS_YAW_FOLLOW",
        [1024] = "GIMBAL_MANAGER_CAP_FLAGS_HAS_YAW_LOCK",
        [2048] = "GIMBAL_MANAGER_CAP_FLAGS_SUPPORTS_INFINITE_YAW",
        [4096] = "GIMBAL_MANAGER_CAP_FLAGS_SUPPORTS_YAW_IN_EARTH_FRAME",
        [8192] = "GIMBAL_MANAGER_CAP_FLAGS_HAS_RC_INPUTS",
        [65536] = "GIMBAL_MANAGER_CAP_FLAGS_CAN_POINT_LOCATION_LOCAL",
        [131072] = "GIMBAL_MANAGER_CAP_FLAGS_CAN_POINT_LOCATION_GLOBAL",
    },
    ["GIMBAL_DEVICE_FLAGS"] = {
        [1] = "GIMBAL_DEVICE_FLAGS_RETRACT",
        [2] = "GIMBAL_DEVICE_FLAGS_NEUTRAL",
        [4] = "GIMBAL_DEVICE_FLAGS_ROLL_LOCK",
        [8] = "GIMBAL_DEVICE_FLAGS_PITCH_LOCK",
        [16] = "GIMBAL_DEVICE_FLAGS_YAW_LOCK",
        [32] = "GIMBAL_DEVICE_FLAGS_YAW_IN_VEHICLE_FRAME",
        [64] = "GIMBAL_DEVICE_FLAGS_YAW_IN_EARTH_FRAME",
        [128] = "GIMBAL_DEVICE_FLAGS_ACCEPTS_YAW_IN_EARTH_FRAME",
        [256] = "GIMBAL_DEVICE_FLAGS_RC_EXCLUSIVE",
        [512] = "GIMBAL_DEVICE_FLAGS_RC_MIXED",
    },
    ["GIMBAL_MANAGER_FLAGS"] = {
        [1] = "GIMBAL_MANAGER_FLAGS_RETRACT",
        [2] = "GIMBAL_MANAGER_FLAGS_NEUTRAL",
        [4] = "GIMBAL_MANAGER_FLAGS_ROLL_LOCK",
        [8] = "GIMBAL_MANAGER_FLAGS_PITCH_LOCK",
        [16] = "GIMBAL_MANAGER_FLAGS_YAW_LOCK",
        [32] = "GIMBAL_MANAGER_FLAGS_YAW_IN_VEHICLE_FRAME",
        [64] = "GIMBAL_MANAGER_FLAGS_YAW_IN_EARTH_FRAME",
        [128] = "GIMBAL_MANAGER_FLAGS_ACCEPTS_YAW_IN_EARTH_FRAME",
        [256] = "GIMBAL_MANAGER_FLAGS_RC_EXCLUSIVE",
        [512] = "GIMBAL_MANAGER_FLAGS_RC_MIXED",
    },
    ["GIMBAL_DEVICE_ERROR_FLAGS"] = {
        [1] = "GIMBAL_DEVICE_ERROR_FLAGS_AT_ROLL_LIMIT",
        [2] = "GIMBAL_DEVICE_ERROR_FLAGS_AT_PITCH_LIMIT",
        [4] = "GIMBAL_DEVICE_ERROR_FLAGS_AT_YAW_LIMIT",
        [8] = "GIMBAL_DEVICE_ERROR_FLAGS_ENCODER_ERROR",
        [16] = "GIMBAL_DEVICE_ERROR_FLAGS_POWER_ERROR",
        [32] = "GIMBAL_DEVICE_ERROR_FLAGS_MOTOR_ERROR",
        [64] = "GIMBAL_DEVICE_ERROR_FLAGS_SOFTWARE_ERROR",
        [128] = "GIMBAL_DEVICE_ERROR_FLAGS_COMMS_ERROR",
        [256] = "GIMBAL_DEVICE_ERROR_FLAGS_CALIBRATION_RUNNING",
        [512] = "GIMBAL_DEVICE_ERROR_FLAGS_NO_MANAGER",
    },
    ["MAV_PARAM_TYPE"] = {
        [1] = "MAV_PARAM_TYPE_UINT8",
        [2] = "MAV_PARAM_TYPE_INT8",
        [3] = "MAV_PARAM_TYPE_UINT16",
        [4] = "MAV_PARAM_TYPE_INT16",
        [5] = "MAV_PARAM_TYPE_UINT32",
        [6] = "MAV_PARAM_TYPE_INT32",
        [7] = "MAV_PARAM_TYPE_UINT64",
        [8] = "MAV_PARAM_TYPE_INT64",
        [9] = "MAV_PARAM_TYPE_REAL32",
        [10] = "MAV_PARAM_TYPE_REAL64",
    },
    ["MAV_PARAM_ERROR"] = {
        [0] = "MAV_PARAM_ERROR_NO_ERROR",
        [1] = "MAV_PARAM_ERROR_DOES_NOT_EXIST",
        [2] = "MAV_PARAM_ERROR_VALUE_OUT_OF_RANGE",
        [3] = "MAV_PARAM_ERROR_PERMISSION_DENIED",
        [4] = "MAV_PARAM_ERROR_COMPONENT_NOT_FOUND",
        [5] = "MAV_PARAM_ERROR_READ_ONLY",
    },
    ["MAV_RESULT"] = {
        [0] = "MAV_RESULT_ACCEPTED",
        [1] = "MAV_RESULT_TEMPORARILY_REJECTED",
        [2] = "MAV_RESULT_DENIED",
        [3] = "MAV_RESULT_UNSUPPORTED",
        [4] = "MAV_RESULT_FAILED",
        [5] = "MAV_RESULT_IN_PROGRESS",
        [7] = "MAV_RESULT_COMMAND_LONG_ONLY",
        [8] = "MAV_RESULT_COMMAND_INT_ONLY",
    },
    ["MAV_SEVERITY"] = {
        [0] = "MAV_SEVERITY_EMERGENCY",
        [1] = "MAV_SEVERITY_ALERT",
        [2] = "MAV_SEVERITY_CRITICAL",
        [3] = "MAV_SEVERITY_ERROR",
        [4] = "MAV_SEVERITY_WARNING",
        [5] = "MAV_SEVERITY_NOTICE",
        [6] = "MAV_SEVERITY_INFO",
        [7] = "MAV_SEVERITY_DEBUG",
    },
    ["MAV_VTOL_STATE"] = {
        [0] = "MAV_VTOL_STATE_UNDEFINED",
        [1] = "MAV_VTOL_STATE_TRANSITION_TO_FW",
        [2] = "MAV_VTOL_STATE_TRANSITION_TO_MC",
        [3] = "MAV_VTOL_STATE_MC",
        [4] = "MAV_VTOL_STATE_FW",
    },
    ["MAV_LANDED_STATE"] = {
        [0] = "MAV_LANDED_STATE_UNDEFINED",
        [1] = "MAV_LANDED_STATE_ON_GROUND",
        [2] = "MAV_LANDED_STATE_IN_AIR",
        [3] = "MAV_LANDED_STATE_TAKEOFF",
        [4] = "MAV_LANDED_STATE_LANDING",
    },
    ["ESTIMATOR_STATUS_FLAGS"] = {
        [1] = "ESTIMATOR_ATTITUDE",
        [2] = "ESTIMATOR_VELOCITY_HORIZ",
        [4] = "ESTIMATOR_VELOCITY_VERT",
        [8] = "ESTIMATOR_POS_HORIZ_REL",
        [16] = "ESTIMATOR_POS_HORIZ_ABS",
        [32] = "ESTIMATOR_POS_VERT_ABS",
        [64] = "ESTIMATOR_POS_VERT_AGL",
        [128] = "ESTIMATOR_CONST_POS_MODE",
        [256] = "ESTIMATOR_PRED_POS_HORIZ_REL",
        [512] = "ESTIMATOR_PRED_POS_HORIZ_ABS",
        [1024] = "ESTIMATOR_GPS_GLITCH",
        [2048] = "ESTIMATOR_ACCEL_ERROR",
    },
    ["POSITION_TARGET_TYPEMASK"] = {
        [1] = "POSITION_TARGET_TYPEMASK_X_IGNORE",
        [2] = "POSITION_TARGET_TYPEMASK_Y_IGNORE",
        [4] = "POSITION_TARGET_TYPEMASK_Z_IGNORE",
        [8] = "POSITION_TARGET_TYPEMASK_VX_IGNORE",
        [16] = "POSITION_TARGET_TYPEMASK_VY_IGNORE",
        [32] = "POSITION_TARGET_TYPEMASK_VZ_IGNORE",
        [64] = "POSITION_TARGET_TYPEMASK_AX_IGNORE",
        [128] = "POSITION_TARGET_TYPEMASK_AY_IGNORE",
        [256] = "POSITION_TARGET_TYPEMASK_AZ_IGNORE",
        [512] = "POSITION_TARGET_TYPEMASK_FORCE_SET",
        [1024] = "POSITION_TARGET_TYPEMASK_YAW_IGNORE",
        [2048] = "POSITION_TARGET_TYPEMASK_YAW_RATE_IGNORE",
    },
    ["MAV_TUNNEL_PAYLOAD_TYPE"] = {
        [0] = "MAV_TUNNEL_PAYLOAD_TYPE_UNKNOWN",
        [200] = "MAV_TUNNEL_PAYLOAD_TYPE_STORM32_RESERVED0",
        [201] = "MAV_TUNNEL_PAYLOAD_TYPE_STORM32_RESERVED1",
        [202] = "MAV_TUNNEL_PAYLOAD_TYPE_STORM32_RESERVED2",
        [203] = "MAV_TUNNEL_PAYLOAD_TYPE_STORM32_RESERVED3",
        [204] = "MAV_TUNNEL_PAYLOAD_TYPE_STORM32_RESERVED4",
        [205] = "MAV_TUNNEL_PAYLOAD_TYPE_STORM32_RESERVED5",
        [206] = "MAV_TUNNEL_PAYLOAD_TYPE_STORM32_RESERVED6",
        [207] = "MAV_TUNNEL_PAYLOAD_TYPE_STORM32_RESERVED7",
        [208] = "MAV_TUNNEL_PAYLOAD_TYPE_STORM32_RESERVED8",
        [209] = "MAV_TUNNEL_PAYLOAD_TYPE_STORM32_RESERVED9",
        [210] = "MAV_TUNNEL_PAYLOAD_TYPE_MODALAI_REMOTE_OSD",
        [211] = "MAV_TUNNEL_PAYLOAD_TYPE_MODALAI_ESC_UART_PASSTHRU",
        [212] = "MAV_TUNNEL_PAYLOAD_TYPE_MODALAI_IO_UART_PASSTHRU",
        [54000] = "ROSS_TUNNEL_TYPE_FRAME",
    },
    ["MAV_FTP_OPCODE"] = {
        [0] = "MAV_FTP_OPCODE_NONE",
        [1] = "MAV_FTP_OPCODE_TERMINATESESSION",
        [2] = "MAV_FTP_OPCODE_RESETSESSION",
        [3] = "MAV_FTP_OPCODE_LISTDIRECTORY",
        [4] = "MAV_FTP_OPCODE_OPENFILERO",
        [5] = "MAV_FTP_OPCODE_READFILE",
        [6] = "MAV_FTP_OPCODE_CREATEFILE",
        [7] = "MAV_FTP_OPCODE_WRITEFILE",
        [8] = "MAV_FTP_OPCODE_REMOVEFILE",
        [9] = "MAV_FTP_OPCODE_CREATEDIRECTORY",
        [10] = "MAV_FTP_OPCODE_REMOVEDIRECTORY",
        [11] = "MAV_FTP_OPCODE_OPENFILEWO",
        [12] = "MAV_FTP_OPCODE_TRUNCATEFILE",
        [13] = "MAV_FTP_OPCODE_RENAME",
        [14] = "MAV_FTP_OPCODE_CALCFILECRC",
        [15] = "MAV_FTP_OPCODE_BURSTREADFILE",
        [128] = "MAV_FTP_OPCODE_ACK",
        [129] = "MAV_FTP_OPCODE_NAK",
    },
    ["COMPUTER_STATUS_FLAGS"] = {
        [1] = "COMPUTER_STATUS_FLAGS_UNDER_VOLTAGE",
        [2] = "COMPUTER_STATUS_FLAGS_CPU_THROTTLE",
        [4] = "COMPUTER_STATUS_FLAGS_THERMAL_THROTTLE",
        [8] = "COMPUTER_STATUS_FLAGS_DISK_FULL",
    },
}
f.magic = ProtoField.uint8("mavlink_proto.magic", "Magic value / version", base.HEX, protocolVersions)
f.length = ProtoField.uint8("mavlink_proto.length", "Payload length")
f.incompatibility_flag = ProtoField.uint8("mavlink_proto.incompatibility_flag", "Incompatibility flag", base.HEX_DEC)
f.compatibility_flag = ProtoField.uint8("mavlink_proto.compatibility_flag", "Compatibility flag", base.HEX_DEC)
f.sequence = ProtoField.uint8("mavlink_proto.sequence", "Packet sequence")
f.sysid = ProtoField.uint8("mavlink_proto.sysid", "System id", base.DEC)
f.compid = ProtoField.uint8("mavlink_proto.compid", "Component id", base.DEC, enumEntryName.MAV_COMPONENT)
f.msgid = ProtoField.uint24("mavlink_proto.msgid", "Message id", base.DEC, messageName)
f.payload = ProtoField.uint8("mavlink_proto.payload", "Payload", base.DEC, messageName)
f.crc = ProtoField.uint16("mavlink_proto.crc", "Message CRC", base.HEX)
f.signature_link = ProtoField.uint8("mavlink_proto.signature_link", "Link id", base.DEC)
f.signature_time = ProtoField.absolute_time("mavlink_proto.signature_time", "Time")
f.signature_signature = ProtoField.bytes("mavlink_proto.signature_signature", "Signature")
f.rawheader = ProtoField.bytes("mavlink_proto.rawheader", "Unparsable header fragment")
f.rawpayload = ProtoField.bytes("mavlink_proto.rawpayload", "Unparsable payload")

-- fields for FILE_TRANSFER_PROTOCOL.payload dissector
f.FILE_TRANSFER_PROTOCOL_payload_seq_number = ProtoField.uint16("mavlink_proto.FILE_TRANSFER_PROTOCOL_payload_seq_number", "seq_number")
f.FILE_TRANSFER_PROTOCOL_payload_session = ProtoField.uint8("mavlink_proto.FILE_TRANSFER_PROTOCOL_payload_session", "payload_session")
f.FILE_TRANSFER_PROTOCOL_payload_opcode = ProtoField.uint8("mavlink_proto.FILE_TRANSFER_PROTOCOL_payload_opcode", "opcode", base.DEC, enumEntryName.MAV_FTP_OPCODE)
f.FILE_TRANSFER_PROTOCOL_payload_size = ProtoField.uint8("mavlink_proto.FILE_TRANSFER_PROTOCOL_payload_size", "payload_size")
f.FILE_TRANSFER_PROTOCOL_payload_req_opcode = ProtoField.uint8("mavlink_proto.FILE_TRANSFER_PROTOCOL_payload_req_opcode", "req_opcode", base.DEC, enumEntryName.MAV_FTP_OPCODE)
f.FILE_TRANSFER_PROTOCOL_payload_burst_complete = ProtoField.uint8("mavlink_proto.FILE_TRANSFER_PROTOCOL_burst_complete", "burst_complete")
f.FILE_TRANSFER_PROTOCOL_payload_offset = ProtoField.int32("mavlink_proto.FILE_TRANSFER_PROTOCOL_payload_offset", "payload_offset")
f.FILE_TRANSFER_PROTOCOL_payload_data = ProtoField.bytes("mavlink_proto.FILE_TRANSFER_PROTOCOL_payload_data", "payload_data")

f.cmd_MAV_CMD_GET_MESSAGE_INTERVAL_param1 = ProtoField.new("param1: Message ID (float)", "mavlink_proto.cmd_MAV_CMD_GET_MESSAGE_INTERVAL_param1", ftypes.FLOAT, nil)

f.cmd_MAV_CMD_SET_MESSAGE_INTERVAL_param1 = ProtoField.new("param1: Message ID (float)", "mavlink_proto.cmd_MAV_CMD_SET_MESSAGE_INTERVAL_param1", ftypes.FLOAT, nil)
f.cmd_MAV_CMD_SET_MESSAGE_INTERVAL_param2 = ProtoField.new("param2: Interval (float) us", "mavlink_proto.cmd_MAV_CMD_SET_MESSAGE_INTERVAL_param2", ftypes.FLOAT, nil)
f.cmd_MAV_CMD_SET_MESSAGE_INTERVAL_param7 = ProtoField.new("param7: Response Target (float)", "mavlink_proto.cmd_MAV_CMD_SET_MESSAGE_INTERVAL_param7", ftypes.FLOAT, nil)
f.cmd_MAV_CMD_SET_MESSAGE_INTERVAL_z = ProtoField.new("z: Response Target (float)", "mavlink_proto.cmd_MAV_CMD_SET_MESSAGE_INTERVAL_z", ftypes.FLOAT, nil)

f.cmd_MAV_CMD_REQUEST_MESSAGE_param1 = ProtoField.new("param1: Message ID (float)", "mavlink_proto.cmd_MAV_CMD_REQUEST_MESSAGE_param1", ftypes.FLOAT, nil)
f.cmd_MAV_CMD_REQUEST_MESSAGE_param2 = ProtoField.new("param2: Req Param 1 (float)", "mavlink_proto.cmd_MAV_CMD_REQUEST_MESSAGE_param2", ftypes.FLOAT, nil)
f.cmd_MAV_CMD_REQUEST_MESSAGE_param3 = ProtoField.new("param3: Req Param 2 (float)", "mavlink_proto.cmd_MAV_CMD_REQUEST_MESSAGE_param3", ftypes.FLOAT, nil)
f.cmd_MAV_CMD_REQUEST_MESSAGE_param4 = ProtoField.new("param4: Req Param 3 (float)", "mavlink_proto.cmd_MAV_CMD_REQUEST_MESSAGE_param4", ftypes.FLOAT, nil)
f.cmd_MAV_CMD_REQUEST_MESSAGE_param5 = ProtoField.new("param5: Req Param 4 (float)", "mavlink_proto.cmd_MAV_CMD_REQUEST_MESSAGE_param5", ftypes.FLOAT, nil)
f.cmd_MAV_CMD_REQUEST_MESSAGE_x = ProtoField.new("x: Req Param 4 (int32_t)", "mavlink_proto.cmd_MAV_CMD_REQUEST_MESSAGE_x", ftypes.INT32, nil)
f.cmd_MAV_CMD_REQUEST_MESSAGE_param6 = ProtoField.new("param6: Req Param 5 (float)", "mavlink_proto.cmd_MAV_CMD_REQUEST_MESSAGE_param6", ftypes.FLOAT, nil)
f.cmd_MAV_CMD_REQUEST_MESSAGE_y = ProtoField.new("y: Req Param 5 (int32_t)", "mavlink_proto.cmd_MAV_CMD_REQUEST_MESSAGE_y", ftypes.INT32, nil)
f.cmd_MAV_CMD_REQUEST_MESSAGE_param7 = ProtoField.new("param7: Response Target (float)", "mavlink_proto.cmd_MAV_CMD_REQUEST_MESSAGE_param7", ftypes.FLOAT, nil)
f.cmd_MAV_CMD_REQUEST_MESSAGE_z = ProtoField.new("z: Response Target (float)", "mavlink_proto.cmd_MAV_CMD_REQUEST_MESSAGE_z", ftypes.FLOAT, nil)


f.cmd_MAV_CMD_ROSS_LISTEN_param1 = ProtoField.new("param1: Mode (ROSS_LISTEN_MODE)", "mavlink_proto.cmd_MAV_CMD_ROSS_LISTEN_param1", ftypes.UINT32, enumEntryName.ROSS_LISTEN_MODE)
f.cmd_MAV_CMD_ROSS_LISTEN_param2 = ProtoField.new("param2: Source (float)", "mavlink_proto.cmd_MAV_CMD_ROSS_LISTEN_param2", ftypes.FLOAT, nil)
f.cmd_MAV_CMD_ROSS_LISTEN_param3 = ProtoField.new("param3: Azimuth (float) deg", "mavlink_proto.cmd_MAV_CMD_ROSS_LISTEN_param3", ftypes.FLOAT, nil)

f.cmd_MAV_CMD_ROSS_INFORM_param1 = ProtoField.new("param1: First (float)", "mavlink_proto.cmd_MAV_CMD_ROSS_INFORM_param1", ftypes.FLOAT, nil)
f.cmd_MAV_CMD_ROSS_INFORM_param2 = ProtoField.new("param2: Azimuth 0 (float) deg", "mavlink_proto.cmd_MAV_CMD_ROSS_INFORM_param2", ftypes.FLOAT, nil)
f.cmd_MAV_CMD_ROSS_INFORM_param3 = ProtoField.new("param3: Azimuth 1 (float) deg", "mavlink_proto.cmd_MAV_CMD_ROSS_INFORM_param3", ftypes.FLOAT, nil)
f.cmd_MAV_CMD_ROSS_INFORM_param4 = ProtoField.new("param4: Azimuth 2 (float) deg", "mavlink_proto.cmd_MAV_CMD_ROSS_INFORM_param4", ftypes.FLOAT, nil)
f.cmd_MAV_CMD_ROSS_INFORM_param5 = ProtoField.new("param5: Azimuth 3 (float) deg", "mavlink_proto.cmd_MAV_CMD_ROSS_INFORM_param5", ftypes.FLOAT, nil)
f.cmd_MAV_CMD_ROSS_INFORM_x = ProtoField.new("x: Azimuth 3 (int32_t) deg", "mavlink_proto.cmd_MAV_CMD_ROSS_INFORM_x", ftypes.INT32, nil)
f.cmd_MAV_CMD_ROSS_INFORM_param6 = ProtoField.new("param6: Azimuth 4 (float) deg", "mavlink_proto.cmd_MAV_CMD_ROSS_INFORM_param6", ftypes.FLOAT, nil)
f.cmd_MAV_CMD_ROSS_INFORM_y = ProtoField.new("y: Azimuth 4 (int32_t) deg", "mavlink_proto.cmd_MAV_CMD_ROSS_INFORM_y", ftypes.INT32, nil)
f.cmd_MAV_CMD_ROSS_INFORM_param7 = ProtoField.new("param7: Azimuth 5 (float) deg", "mavlink_proto.cmd_MAV_CMD_ROSS_INFORM_param7", ftypes.FLOAT, nil)
f.cmd_MAV_CMD_ROSS_INFORM_z = ProtoField.new("z: Azimuth 5 (float) deg", "mavlink_proto.cmd_MAV_CMD_ROSS_INFORM_z", ftypes.FLOAT, nil)

f.cmd_MAV_CMD_ROSS_TURN_param1 = ProtoField.new("param1: Heading (float) deg", "mavlink_proto.cmd_MAV_CMD_ROSS_TURN_param1", ftypes.FLOAT, nil)




f.cmd_MAV_CMD_ROSS_MEASURE_NOISE_param1 = ProtoField.new("param1: Time (float) s", "mavlink_proto.cmd_MAV_CMD_ROSS_MEASURE_NOISE_param1", ftypes.FLOAT, nil)

f.cmd_MAV_CMD_ROSS_RECORD_param1 = ProtoField.new("param1: Start (float)", "mavlink_proto.cmd_MAV_CMD_ROSS_RECORD_param1", ftypes.FLOAT, nil)



f.cmd_MAV_CMD_ROSS_STREAM_param1 = ProtoField.new("param1: Stream (float)", "mavlink_proto.cmd_MAV_CMD_ROSS_STREAM_param1", ftypes.FLOAT, nil)
f.cmd_MAV_CMD_ROSS_STREAM_param2 = ProtoField.new("param2: Selection (ROSS_SELECTION)", "mavlink_proto.cmd_MAV_CMD_ROSS_STREAM_param2", ftypes.UINT32, enumEntryName.ROSS_SELECTION)
f.cmd_MAV_CMD_ROSS_STREAM_param3 = ProtoField.new("param3: Which (float)", "mavlink_proto.cmd_MAV_CMD_ROSS_STREAM_param3", ftypes.FLOAT, nil)
f.cmd_MAV_CMD_ROSS_STREAM_param4 = ProtoField.new("param4: Gain (float) dB", "mavlink_proto.cmd_MAV_CMD_ROSS_STREAM_param4", ftypes.FLOAT, nil)
f.cmd_MAV_CMD_ROSS_STREAM_param5 = ProtoField.new("param5: Address 1 (float)", "mavlink_proto.cmd_MAV_CMD_ROSS_STREAM_param5", ftypes.FLOAT, nil)
f.cmd_MAV_CMD_ROSS_STREAM_x = ProtoField.new("x: Address 1 (int32_t)", "mavlink_proto.cmd_MAV_CMD_ROSS_STREAM_x", ftypes.INT32, nil)
f.cmd_MAV_CMD_ROSS_STREAM_param6 = ProtoField.new("param6: Address 2 (float)", "mavlink_proto.cmd_MAV_CMD_ROSS_STREAM_param6", ftypes.FLOAT, nil)
f.cmd_MAV_CMD_ROSS_STREAM_y = ProtoField.new("y: Address 2 (int32_t)", "mavlink_proto.cmd_MAV_CMD_ROSS_STREAM_y", ftypes.INT32, nil)
f.cmd_MAV_CMD_ROSS_STREAM_param7 = ProtoField.new("param7: Port and codec (float)", "mavlink_proto.cmd_MAV_CMD_ROSS_STREAM_param7", ftypes.FLOAT, nil)
f.cmd_MAV_CMD_ROSS_STREAM_z = ProtoField.new("z: Port and codec (float)", "mavlink_proto.cmd_MAV_CMD_ROSS_STREAM_z", ftypes.FLOAT, nil)

f.cmd_MAV_CMD_ROSS_ENROL_param1 = ProtoField.new("param1: Mode (ROSS_LISTEN_MODE)", "mavlink_proto.cmd_MAV_CMD_ROSS_ENROL_param1", ftypes.UINT32, enumEntryName.ROSS_LISTEN_MODE)
f.cmd_MAV_CMD_ROSS_ENROL_param2 = ProtoField.new("param2: Source (float)", "mavlink_proto.cmd_MAV_CMD_ROSS_ENROL_param2", ftypes.FLOAT, nil)
f.cmd_MAV_CMD_ROSS_ENROL_param3 = ProtoField.new("param3: Azimuth (float) deg", "mavlink_proto.cmd_MAV_CMD_ROSS_ENROL_param3", ftypes.FLOAT, nil)
f.cmd_MAV_CMD_ROSS_ENROL_param4 = ProtoField.new("param4: Time (float) s", "mavlink_proto.cmd_MAV_CMD_ROSS_ENROL_param4", ftypes.FLOAT, nil)
f.cmd_MAV_CMD_ROSS_ENROL_param5 = ProtoField.new("param5: Consent (float)", "mavlink_proto.cmd_MAV_CMD_ROSS_ENROL_param5", ftypes.FLOAT, nil)
f.cmd_MAV_CMD_ROSS_ENROL_x = ProtoField.new("x: Consent (int32_t)", "mavlink_proto.cmd_MAV_CMD_ROSS_ENROL_x", ftypes.INT32, nil)
f.cmd_MAV_CMD_ROSS_ENROL_param6 = ProtoField.new("param6: Name (float)", "mavlink_proto.cmd_MAV_CMD_ROSS_ENROL_param6", ftypes.FLOAT, nil)
f.cmd_MAV_CMD_ROSS_ENROL_y = ProtoField.new("y: Name (int32_t)", "mavlink_proto.cmd_MAV_CMD_ROSS_ENROL_y", ftypes.INT32, nil)


f.ROSS_INFORMATION_time_usec = ProtoField.new("time_usec (uint64_t) [us]", "mavlink_proto.ROSS_INFORMATION_time_usec", ftypes.UINT64, nil)
f.ROSS_INFORMATION_dialect_version = ProtoField.new("dialect_version (uint16_t)", "mavlink_proto.ROSS_INFORMATION_dialect_version", ftypes.UINT16, nil)
f.ROSS_INFORMATION_spacing = ProtoField.new("spacing (float) [m]", "mavlink_proto.ROSS_INFORMATION_spacing", ftypes.FLOAT, nil)
f.ROSS_INFORMATION_speed_of_sound = ProtoField.new("speed_of_sound (float) [m/s]", "mavlink_proto.ROSS_INFORMATION_speed_of_sound", ftypes.FLOAT, nil)
f.ROSS_INFORMATION_axis_offset = ProtoField.new("axis_offset (float) [rad]", "mavlink_proto.ROSS_INFORMATION_axis_offset", ftypes.FLOAT, nil)
f.ROSS_INFORMATION_joint_min = ProtoField.new("joint_min (float) [rad]", "mavlink_proto.ROSS_INFORMATION_joint_min", ftypes.FLOAT, nil)
f.ROSS_INFORMATION_joint_max = ProtoField.new("joint_max (float) [rad]", "mavlink_proto.ROSS_INFORMATION_joint_max", ftypes.FLOAT, nil)
f.ROSS_INFORMATION_joint_rate_max = ProtoField.new("joint_rate_max (float) [rad/s]", "mavlink_proto.ROSS_INFORMATION_joint_rate_max", ftypes.FLOAT, nil)
f.ROSS_INFORMATION_orientation_time = ProtoField.new("orientation_time (float) [s]", "mavlink_proto.ROSS_INFORMATION_orientation_time", ftypes.FLOAT, nil)
f.ROSS_INFORMATION_sample_rate = ProtoField.new("sample_rate (uint32_t) [Hz]", "mavlink_proto.ROSS_INFORMATION_sample_rate", ftypes.UINT32, nil)
f.ROSS_INFORMATION_k_max = ProtoField.new("k_max (uint8_t)", "mavlink_proto.ROSS_INFORMATION_k_max", ftypes.UINT8, nil)
f.ROSS_INFORMATION_software_version = ProtoField.new("software_version (char)", "mavlink_proto.ROSS_INFORMATION_software_version", ftypes.STRING, nil)
f.ROSS_INFORMATION_actuator = ProtoField.new("actuator (char)", "mavlink_proto.ROSS_INFORMATION_actuator", ftypes.STRING, nil)

f.ROSS_STATUS_time_usec = ProtoField.new("time_usec (uint64_t) [us]", "mavlink_proto.ROSS_STATUS_time_usec", ftypes.UINT64, nil)
f.ROSS_STATUS_mission_time = ProtoField.new("mission_time (uint32_t) [ms]", "mavlink_proto.ROSS_STATUS_mission_time", ftypes.UINT32, nil)
f.ROSS_STATUS_state = ProtoField.new("state (ROSS_STATE)", "mavlink_proto.ROSS_STATUS_state", ftypes.UINT8, enumEntryName.ROSS_STATE)
f.ROSS_STATUS_outcome = ProtoField.new("outcome (ROSS_OUTCOME)", "mavlink_proto.ROSS_STATUS_outcome", ftypes.UINT8, enumEntryName.ROSS_OUTCOME)
f.ROSS_STATUS_frame = ProtoField.new("frame (ROSS_FRAME)", "mavlink_proto.ROSS_STATUS_frame", ftypes.UINT8, enumEntryName.ROSS_FRAME)
f.ROSS_STATUS_flags = ProtoField.new("flags (ROSS_STATUS_FLAGS)", "mavlink_proto.ROSS_STATUS_flags", ftypes.UINT8, nil, base.HEX_DEC)
f.ROSS_STATUS_flags_flagROSS_STATUS_FLAGS_NOISE_MEASURED = ProtoField.bool("mavlink_proto.ROSS_STATUS_flags.ROSS_STATUS_FLAGS_NOISE_MEASURED", "ROSS_STATUS_FLAGS_NOISE_MEASURED", 8, nil, 1)
f.ROSS_STATUS_flags_flagROSS_STATUS_FLAGS_CERTAIN = ProtoField.bool("mavlink_proto.ROSS_STATUS_flags.ROSS_STATUS_FLAGS_CERTAIN", "ROSS_STATUS_FLAGS_CERTAIN", 8, nil, 2)
f.ROSS_STATUS_flags_flagROSS_STATUS_FLAGS_TARGET_FOUND = ProtoField.bool("mavlink_proto.ROSS_STATUS_flags.ROSS_STATUS_FLAGS_TARGET_FOUND", "ROSS_STATUS_FLAGS_TARGET_FOUND", 8, nil, 4)
f.ROSS_STATUS_flags_flagROSS_STATUS_FLAGS_TIME_UNIX = ProtoField.bool("mavlink_proto.ROSS_STATUS_flags.ROSS_STATUS_FLAGS_TIME_UNIX", "ROSS_STATUS_FLAGS_TIME_UNIX", 8, nil, 8)
f.ROSS_STATUS_flags_flagROSS_STATUS_FLAGS_STREAMING = ProtoField.bool("mavlink_proto.ROSS_STATUS_flags.ROSS_STATUS_FLAGS_STREAMING", "ROSS_STATUS_FLAGS_STREAMING", 8, nil, 16)
f.ROSS_STATUS_flags_flagROSS_STATUS_FLAGS_RECORDING = ProtoField.bool("mavlink_proto.ROSS_STATUS_flags.ROSS_STATUS_FLAGS_RECORDING", "ROSS_STATUS_FLAGS_RECORDING", 8, nil, 32)
f.ROSS_STATUS_actuator_flags = ProtoField.new("actuator_flags (ROSS_ACTUATOR_FLAGS)", "mavlink_proto.ROSS_STATUS_actuator_flags", ftypes.UINT16, nil, base.HEX_DEC)
f.ROSS_STATUS_actuator_flags_flagROSS_ACTUATOR_FLAGS_PRESENT = ProtoField.bool("mavlink_proto.ROSS_STATUS_actuator_flags.ROSS_ACTUATOR_FLAGS_PRESENT", "ROSS_ACTUATOR_FLAGS_PRESENT", 8, nil, 1)
f.ROSS_STATUS_actuator_flags_flagROSS_ACTUATOR_FLAGS_SETTLED = ProtoField.bool("mavlink_proto.ROSS_STATUS_actuator_flags.ROSS_ACTUATOR_FLAGS_SETTLED", "ROSS_ACTUATOR_FLAGS_SETTLED", 8, nil, 2)
f.ROSS_STATUS_actuator_flags_flagROSS_ACTUATOR_FLAGS_HOMED = ProtoField.bool("mavlink_proto.ROSS_STATUS_actuator_flags.ROSS_ACTUATOR_FLAGS_HOMED", "ROSS_ACTUATOR_FLAGS_HOMED", 8, nil, 4)
f.ROSS_STATUS_actuator_flags_flagROSS_ACTUATOR_FLAGS_FAULT = ProtoField.bool("mavlink_proto.ROSS_STATUS_actuator_flags.ROSS_ACTUATOR_FLAGS_FAULT", "ROSS_ACTUATOR_FLAGS_FAULT", 8, nil, 8)
f.ROSS_STATUS_actuator_flags_flagROSS_ACTUATOR_FLAGS_OPEN_LOOP = ProtoField.bool("mavlink_proto.ROSS_STATUS_actuator_flags.ROSS_ACTUATOR_FLAGS_OPEN_LOOP", "ROSS_ACTUATOR_FLAGS_OPEN_LOOP", 8, nil, 16)
f.ROSS_STATUS_heading = ProtoField.new("heading (float) [rad]", "mavlink_proto.ROSS_STATUS_heading", ftypes.FLOAT, nil)
f.ROSS_STATUS_heading_goal = ProtoField.new("heading_goal (float) [rad]", "mavlink_proto.ROSS_STATUS_heading_goal", ftypes.FLOAT, nil)
f.ROSS_STATUS_joint = ProtoField.new("joint (float) [rad]", "mavlink_proto.ROSS_STATUS_joint", ftypes.FLOAT, nil)
f.ROSS_STATUS_joint_rate = ProtoField.new("joint_rate (float) [rad/s]", "mavlink_proto.ROSS_STATUS_joint_rate", ftypes.FLOAT, nil)
f.ROSS_STATUS_mount_yaw = ProtoField.new("mount_yaw (float) [rad]", "mavlink_proto.ROSS_STATUS_mount_yaw", ftypes.FLOAT, nil)
f.ROSS_STATUS_score = ProtoField.new("score (float)", "mavlink_proto.ROSS_STATUS_score", ftypes.FLOAT, nil)
f.ROSS_STATUS_criterion = ProtoField.new("criterion (float)", "mavlink_proto.ROSS_STATUS_criterion", ftypes.FLOAT, nil)
f.ROSS_STATUS_rotation = ProtoField.new("rotation (uint8_t)", "mavlink_proto.ROSS_STATUS_rotation", ftypes.UINT8, nil)
f.ROSS_STATUS_rotation_max = ProtoField.new("rotation_max (uint8_t)", "mavlink_proto.ROSS_STATUS_rotation_max", ftypes.UINT8, nil)
f.ROSS_STATUS_k = ProtoField.new("k (uint8_t)", "mavlink_proto.ROSS_STATUS_k", ftypes.UINT8, nil)
f.ROSS_STATUS_target = ProtoField.new("target (uint8_t)", "mavlink_proto.ROSS_STATUS_target", ftypes.UINT8, nil)

f.ROSS_SOURCE_time_usec = ProtoField.new("time_usec (uint64_t) [us]", "mavlink_proto.ROSS_SOURCE_time_usec", ftypes.UINT64, nil)
f.ROSS_SOURCE_azimuth = ProtoField.new("azimuth (float) [rad]", "mavlink_proto.ROSS_SOURCE_azimuth", ftypes.FLOAT, nil)
f.ROSS_SOURCE_azimuth_mirror = ProtoField.new("azimuth_mirror (float) [rad]", "mavlink_proto.ROSS_SOURCE_azimuth_mirror", ftypes.FLOAT, nil)
f.ROSS_SOURCE_azimuth_sigma = ProtoField.new("azimuth_sigma (float) [rad]", "mavlink_proto.ROSS_SOURCE_azimuth_sigma", ftypes.FLOAT, nil)
f.ROSS_SOURCE_elevation = ProtoField.new("elevation (float) [rad]", "mavlink_proto.ROSS_SOURCE_elevation", ftypes.FLOAT, nil)
f.ROSS_SOURCE_confidence = ProtoField.new("confidence (float)", "mavlink_proto.ROSS_SOURCE_confidence", ftypes.FLOAT, nil)
f.ROSS_SOURCE_weight = ProtoField.new("weight (float)", "mavlink_proto.ROSS_SOURCE_weight", ftypes.FLOAT, nil)
f.ROSS_SOURCE_score = ProtoField.new("score (float)", "mavlink_proto.ROSS_SOURCE_score", ftypes.FLOAT, nil)
f.ROSS_SOURCE_estimate = ProtoField.new("estimate (uint16_t)", "mavlink_proto.ROSS_SOURCE_estimate", ftypes.UINT16, nil)
f.ROSS_SOURCE_source = ProtoField.new("source (uint8_t)", "mavlink_proto.ROSS_SOURCE_source", ftypes.UINT8, nil)
f.ROSS_SOURCE_count = ProtoField.new("count (uint8_t)", "mavlink_proto.ROSS_SOURCE_count", ftypes.UINT8, nil)
f.ROSS_SOURCE_frame = ProtoField.new("frame (ROSS_FRAME)", "mavlink_proto.ROSS_SOURCE_frame", ftypes.UINT8, enumEntryName.ROSS_FRAME)
f.ROSS_SOURCE_flags = ProtoField.new("flags (ROSS_SOURCE_FLAGS)", "mavlink_proto.ROSS_SOURCE_flags", ftypes.UINT8, nil, base.HEX_DEC)
f.ROSS_SOURCE_flags_flagROSS_SOURCE_FLAGS_RESOLVED = ProtoField.bool("mavlink_proto.ROSS_SOURCE_flags.ROSS_SOURCE_FLAGS_RESOLVED", "ROSS_SOURCE_FLAGS_RESOLVED", 4, nil, 1)
f.ROSS_SOURCE_flags_flagROSS_SOURCE_FLAGS_TARGET = ProtoField.bool("mavlink_proto.ROSS_SOURCE_flags.ROSS_SOURCE_FLAGS_TARGET", "ROSS_SOURCE_FLAGS_TARGET", 4, nil, 2)
f.ROSS_SOURCE_flags_flagROSS_SOURCE_FLAGS_FINAL = ProtoField.bool("mavlink_proto.ROSS_SOURCE_flags.ROSS_SOURCE_FLAGS_FINAL", "ROSS_SOURCE_FLAGS_FINAL", 4, nil, 4)
f.ROSS_SOURCE_flags_flagROSS_SOURCE_FLAGS_TRACKED = ProtoField.bool("mavlink_proto.ROSS_SOURCE_flags.ROSS_SOURCE_FLAGS_TRACKED", "ROSS_SOURCE_FLAGS_TRACKED", 4, nil, 8)
f.ROSS_SOURCE_azimuth_rate = ProtoField.new("azimuth_rate (float) [rad/s]", "mavlink_proto.ROSS_SOURCE_azimuth_rate", ftypes.FLOAT, nil)
f.ROSS_SOURCE_age = ProtoField.new("age (float) [s]", "mavlink_proto.ROSS_SOURCE_age", ftypes.FLOAT, nil)

f.ROSS_ALIGNMENT_time_usec = ProtoField.new("time_usec (uint64_t) [us]", "mavlink_proto.ROSS_ALIGNMENT_time_usec", ftypes.UINT64, nil)
f.ROSS_ALIGNMENT_aliased = ProtoField.new("aliased (uint32_t)", "mavlink_proto.ROSS_ALIGNMENT_aliased", ftypes.UINT32, nil, base.HEX_DEC)
f.ROSS_ALIGNMENT_heading = ProtoField.new("heading (float) [rad]", "mavlink_proto.ROSS_ALIGNMENT_heading", ftypes.FLOAT, nil)
f.ROSS_ALIGNMENT_joint = ProtoField.new("joint (float) [rad]", "mavlink_proto.ROSS_ALIGNMENT_joint", ftypes.FLOAT, nil)
f.ROSS_ALIGNMENT_isolation = ProtoField.new("isolation (float) [us]", "mavlink_proto.ROSS_ALIGNMENT_isolation", ftypes.FLOAT, nil)
f.ROSS_ALIGNMENT_plan = ProtoField.new("plan (uint16_t)", "mavlink_proto.ROSS_ALIGNMENT_plan", ftypes.UINT16, nil)
f.ROSS_ALIGNMENT_candidate = ProtoField.new("candidate (uint8_t)", "mavlink_proto.ROSS_ALIGNMENT_candidate", ftypes.UINT8, nil)
f.ROSS_ALIGNMENT_count = ProtoField.new("count (uint8_t)", "mavlink_proto.ROSS_ALIGNMENT_count", ftypes.UINT8, nil)
f.ROSS_ALIGNMENT_source = ProtoField.new("source (uint8_t)", "mavlink_proto.ROSS_ALIGNMENT_source", ftypes.UINT8, nil)
f.ROSS_ALIGNMENT_rule = ProtoField.new("rule (ROSS_ALIGNMENT_RULE)", "mavlink_proto.ROSS_ALIGNMENT_rule", ftypes.UINT8, enumEntryName.ROSS_ALIGNMENT_RULE)
f.ROSS_ALIGNMENT_state = ProtoField.new("state (ROSS_CANDIDATE_STATE)", "mavlink_proto.ROSS_ALIGNMENT_state", ftypes.UINT8, enumEntryName.ROSS_CANDIDATE_STATE)
f.ROSS_ALIGNMENT_frame = ProtoField.new("frame (ROSS_FRAME)", "mavlink_proto.ROSS_ALIGNMENT_frame", ftypes.UINT8, enumEntryName.ROSS_FRAME)
f.ROSS_ALIGNMENT_gain = ProtoField.new("gain (float) [dB]", "mavlink_proto.ROSS_ALIGNMENT_gain", ftypes.FLOAT, nil)

f.ROSS_SEPARATION_time_usec = ProtoField.new("time_usec (uint64_t) [us]", "mavlink_proto.ROSS_SEPARATION_time_usec", ftypes.UINT64, nil)
f.ROSS_SEPARATION_members = ProtoField.new("members (uint32_t)", "mavlink_proto.ROSS_SEPARATION_members", ftypes.UINT32, nil, base.HEX_DEC)
f.ROSS_SEPARATION_heading = ProtoField.new("heading (float) [rad]", "mavlink_proto.ROSS_SEPARATION_heading", ftypes.FLOAT, nil)
f.ROSS_SEPARATION_score = ProtoField.new("score (float)", "mavlink_proto.ROSS_SEPARATION_score", ftypes.FLOAT, nil)
f.ROSS_SEPARATION_criterion = ProtoField.new("criterion (float)", "mavlink_proto.ROSS_SEPARATION_criterion", ftypes.FLOAT, nil)
f.ROSS_SEPARATION_si_sdr = ProtoField.new("si_sdr (float) [dB]", "mavlink_proto.ROSS_SEPARATION_si_sdr", ftypes.FLOAT, nil)
f.ROSS_SEPARATION_si_sdr_improvement = ProtoField.new("si_sdr_improvement (float) [dB]", "mavlink_proto.ROSS_SEPARATION_si_sdr_improvement", ftypes.FLOAT, nil)
f.ROSS_SEPARATION_separation = ProtoField.new("separation (uint16_t)", "mavlink_proto.ROSS_SEPARATION_separation", ftypes.UINT16, nil)
f.ROSS_SEPARATION_group = ProtoField.new("group (uint8_t)", "mavlink_proto.ROSS_SEPARATION_group", ftypes.UINT8, nil)
f.ROSS_SEPARATION_count = ProtoField.new("count (uint8_t)", "mavlink_proto.ROSS_SEPARATION_count", ftypes.UINT8, nil)
f.ROSS_SEPARATION_phase = ProtoField.new("phase (ROSS_SEPARATION_PHASE)", "mavlink_proto.ROSS_SEPARATION_phase", ftypes.UINT8, enumEntryName.ROSS_SEPARATION_PHASE)
f.ROSS_SEPARATION_frame = ProtoField.new("frame (ROSS_FRAME)", "mavlink_proto.ROSS_SEPARATION_frame", ftypes.UINT8, enumEntryName.ROSS_FRAME)
f.ROSS_SEPARATION_flags = ProtoField.new("flags (ROSS_GROUP_FLAGS)", "mavlink_proto.ROSS_SEPARATION_flags", ftypes.UINT8, nil, base.HEX_DEC)
f.ROSS_SEPARATION_flags_flagROSS_GROUP_FLAGS_ACCEPTED = ProtoField.bool("mavlink_proto.ROSS_SEPARATION_flags.ROSS_GROUP_FLAGS_ACCEPTED", "ROSS_GROUP_FLAGS_ACCEPTED", 4, nil, 1)
f.ROSS_SEPARATION_flags_flagROSS_GROUP_FLAGS_TARGET = ProtoField.bool("mavlink_proto.ROSS_SEPARATION_flags.ROSS_GROUP_FLAGS_TARGET", "ROSS_GROUP_FLAGS_TARGET", 4, nil, 2)
f.ROSS_SEPARATION_method = ProtoField.new("method (char)", "mavlink_proto.ROSS_SEPARATION_method", ftypes.STRING, nil)

f.ROSS_AUDIO_time_usec = ProtoField.new("time_usec (uint64_t) [us]", "mavlink_proto.ROSS_AUDIO_time_usec", ftypes.UINT64, nil)
f.ROSS_AUDIO_lost = ProtoField.new("lost (uint32_t)", "mavlink_proto.ROSS_AUDIO_lost", ftypes.UINT32, nil)
for i = 0, 1 do
    f["ROSS_AUDIO_level_"..i] = ProtoField.new("level["..i.."] (float) [dB]", "mavlink_proto.ROSS_AUDIO_level_"..i, ftypes.FLOAT, nil)
end
for i = 0, 1 do
    f["ROSS_AUDIO_peak_"..i] = ProtoField.new("peak["..i.."] (float) [dB]", "mavlink_proto.ROSS_AUDIO_peak_"..i, ftypes.FLOAT, nil)
end
f.ROSS_AUDIO_waiting = ProtoField.new("waiting (float) [s]", "mavlink_proto.ROSS_AUDIO_waiting", ftypes.FLOAT, nil)
f.ROSS_AUDIO_rate = ProtoField.new("rate (float) [Hz]", "mavlink_proto.ROSS_AUDIO_rate", ftypes.FLOAT, nil)
f.ROSS_AUDIO_reopened = ProtoField.new("reopened (uint16_t)", "mavlink_proto.ROSS_AUDIO_reopened", ftypes.UINT16, nil)
f.ROSS_AUDIO_trouble = ProtoField.new("trouble (ROSS_AUDIO_TROUBLE)", "mavlink_proto.ROSS_AUDIO_trouble", ftypes.UINT16, nil, base.HEX_DEC)
f.ROSS_AUDIO_trouble_flagROSS_AUDIO_TROUBLE_CLIPPING = ProtoField.bool("mavlink_proto.ROSS_AUDIO_trouble.ROSS_AUDIO_TROUBLE_CLIPPING", "ROSS_AUDIO_TROUBLE_CLIPPING", 8, nil, 1)
f.ROSS_AUDIO_trouble_flagROSS_AUDIO_TROUBLE_DEAD_1 = ProtoField.bool("mavlink_proto.ROSS_AUDIO_trouble.ROSS_AUDIO_TROUBLE_DEAD_1", "ROSS_AUDIO_TROUBLE_DEAD_1", 8, nil, 2)
f.ROSS_AUDIO_trouble_flagROSS_AUDIO_TROUBLE_DEAD_2 = ProtoField.bool("mavlink_proto.ROSS_AUDIO_trouble.ROSS_AUDIO_TROUBLE_DEAD_2", "ROSS_AUDIO_TROUBLE_DEAD_2", 8, nil, 4)
f.ROSS_AUDIO_trouble_flagROSS_AUDIO_TROUBLE_OFFSET = ProtoField.bool("mavlink_proto.ROSS_AUDIO_trouble.ROSS_AUDIO_TROUBLE_OFFSET", "ROSS_AUDIO_TROUBLE_OFFSET", 8, nil, 8)
f.ROSS_AUDIO_trouble_flagROSS_AUDIO_TROUBLE_IDENTICAL = ProtoField.bool("mavlink_proto.ROSS_AUDIO_trouble.ROSS_AUDIO_TROUBLE_IDENTICAL", "ROSS_AUDIO_TROUBLE_IDENTICAL", 8, nil, 16)
f.ROSS_AUDIO_trouble_flagROSS_AUDIO_TROUBLE_INVERTED = ProtoField.bool("mavlink_proto.ROSS_AUDIO_trouble.ROSS_AUDIO_TROUBLE_INVERTED", "ROSS_AUDIO_TROUBLE_INVERTED", 8, nil, 32)
f.ROSS_AUDIO_trouble_flagROSS_AUDIO_TROUBLE_LOST = ProtoField.bool("mavlink_proto.ROSS_AUDIO_trouble.ROSS_AUDIO_TROUBLE_LOST", "ROSS_AUDIO_TROUBLE_LOST", 8, nil, 64)
f.ROSS_AUDIO_trouble_flagROSS_AUDIO_TROUBLE_ABSENT = ProtoField.bool("mavlink_proto.ROSS_AUDIO_trouble.ROSS_AUDIO_TROUBLE_ABSENT", "ROSS_AUDIO_TROUBLE_ABSENT", 8, nil, 128)

f.ROSS_RECORDING_time_usec = ProtoField.new("time_usec (uint64_t) [us]", "mavlink_proto.ROSS_RECORDING_time_usec", ftypes.UINT64, nil)
f.ROSS_RECORDING_duration = ProtoField.new("duration (float) [s]", "mavlink_proto.ROSS_RECORDING_duration", ftypes.FLOAT, nil)
f.ROSS_RECORDING_free = ProtoField.new("free (float) [MiB]", "mavlink_proto.ROSS_RECORDING_free", ftypes.FLOAT, nil)
f.ROSS_RECORDING_state = ProtoField.new("state (ROSS_RECORDING_STATE)", "mavlink_proto.ROSS_RECORDING_state", ftypes.UINT8, enumEntryName.ROSS_RECORDING_STATE)
f.ROSS_RECORDING_name = ProtoField.new("name (char)", "mavlink_proto.ROSS_RECORDING_name", ftypes.STRING, nil)
f.ROSS_RECORDING_reason = ProtoField.new("reason (char)", "mavlink_proto.ROSS_RECORDING_reason", ftypes.STRING, nil)

f.ROSS_DENSITY_time_usec = ProtoField.new("time_usec (uint64_t) [us]", "mavlink_proto.ROSS_DENSITY_time_usec", ftypes.UINT64, nil)
f.ROSS_DENSITY_heading = ProtoField.new("heading (float) [rad]", "mavlink_proto.ROSS_DENSITY_heading", ftypes.FLOAT, nil)
f.ROSS_DENSITY_itd_first = ProtoField.new("itd_first (float) [us]", "mavlink_proto.ROSS_DENSITY_itd_first", ftypes.FLOAT, nil)
f.ROSS_DENSITY_itd_last = ProtoField.new("itd_last (float) [us]", "mavlink_proto.ROSS_DENSITY_itd_last", ftypes.FLOAT, nil)
f.ROSS_DENSITY_exploration = ProtoField.new("exploration (uint16_t)", "mavlink_proto.ROSS_DENSITY_exploration", ftypes.UINT16, nil)
f.ROSS_DENSITY_rotation = ProtoField.new("rotation (uint8_t)", "mavlink_proto.ROSS_DENSITY_rotation", ftypes.UINT8, nil)
f.ROSS_DENSITY_frame = ProtoField.new("frame (ROSS_FRAME)", "mavlink_proto.ROSS_DENSITY_frame", ftypes.UINT8, enumEntryName.ROSS_FRAME)
for i = 0, 79 do
    f["ROSS_DENSITY_density_"..i] = ProtoField.new("density["..i.."] (uint8_t)", "mavlink_proto.ROSS_DENSITY_density_"..i, ftypes.UINT8, nil)
end

f.ROSS_ISOLATION_time_usec = ProtoField.new("time_usec (uint64_t) [us]", "mavlink_proto.ROSS_ISOLATION_time_usec", ftypes.UINT64, nil)
f.ROSS_ISOLATION_heading_first = ProtoField.new("heading_first (float) [rad]", "mavlink_proto.ROSS_ISOLATION_heading_first", ftypes.FLOAT, nil)
f.ROSS_ISOLATION_heading_last = ProtoField.new("heading_last (float) [rad]", "mavlink_proto.ROSS_ISOLATION_heading_last", ftypes.FLOAT, nil)
f.ROSS_ISOLATION_maximum = ProtoField.new("maximum (float) [us]", "mavlink_proto.ROSS_ISOLATION_maximum", ftypes.FLOAT, nil)
f.ROSS_ISOLATION_plan = ProtoField.new("plan (uint16_t)", "mavlink_proto.ROSS_ISOLATION_plan", ftypes.UINT16, nil)
f.ROSS_ISOLATION_source = ProtoField.new("source (uint8_t)", "mavlink_proto.ROSS_ISOLATION_source", ftypes.UINT8, nil)
f.ROSS_ISOLATION_frame = ProtoField.new("frame (ROSS_FRAME)", "mavlink_proto.ROSS_ISOLATION_frame", ftypes.UINT8, enumEntryName.ROSS_FRAME)
for i = 0, 79 do
    f["ROSS_ISOLATION_isolation_"..i] = ProtoField.new("isolation["..i.."] (uint8_t)", "mavlink_proto.ROSS_ISOLATION_isolation_"..i, ftypes.UINT8, nil)
end

f.ROSS_LINK_time_usec = ProtoField.new("time_usec (uint64_t) [us]", "mavlink_proto.ROSS_LINK_time_usec", ftypes.UINT64, nil)
f.ROSS_LINK_sent = ProtoField.new("sent (uint32_t)", "mavlink_proto.ROSS_LINK_sent", ftypes.UINT32, nil)
f.ROSS_LINK_dropped = ProtoField.new("dropped (uint32_t)", "mavlink_proto.ROSS_LINK_dropped", ftypes.UINT32, nil)
f.ROSS_LINK_received = ProtoField.new("received (uint32_t)", "mavlink_proto.ROSS_LINK_received", ftypes.UINT32, nil)
f.ROSS_LINK_lost = ProtoField.new("lost (uint32_t)", "mavlink_proto.ROSS_LINK_lost", ftypes.UINT32, nil)
f.ROSS_LINK_bad = ProtoField.new("bad (uint32_t)", "mavlink_proto.ROSS_LINK_bad", ftypes.UINT32, nil)
f.ROSS_LINK_refused = ProtoField.new("refused (uint32_t)", "mavlink_proto.ROSS_LINK_refused", ftypes.UINT32, nil)
f.ROSS_LINK_reconnects = ProtoField.new("reconnects (uint16_t)", "mavlink_proto.ROSS_LINK_reconnects", ftypes.UINT16, nil)
f.ROSS_LINK_link = ProtoField.new("link (uint8_t)", "mavlink_proto.ROSS_LINK_link", ftypes.UINT8, nil)
f.ROSS_LINK_count = ProtoField.new("count (uint8_t)", "mavlink_proto.ROSS_LINK_count", ftypes.UINT8, nil)
f.ROSS_LINK_flags = ProtoField.new("flags (ROSS_LINK_FLAGS)", "mavlink_proto.ROSS_LINK_flags", ftypes.UINT8, nil, base.HEX_DEC)
f.ROSS_LINK_flags_flagROSS_LINK_FLAGS_UP = ProtoField.bool("mavlink_proto.ROSS_LINK_flags.ROSS_LINK_FLAGS_UP", "ROSS_LINK_FLAGS_UP", 4, nil, 1)
f.ROSS_LINK_flags_flagROSS_LINK_FLAGS_AUTOPILOT = ProtoField.bool("mavlink_proto.ROSS_LINK_flags.ROSS_LINK_FLAGS_AUTOPILOT", "ROSS_LINK_FLAGS_AUTOPILOT", 4, nil, 2)
f.ROSS_LINK_url = ProtoField.new("url (char)", "mavlink_proto.ROSS_LINK_url", ftypes.STRING, nil)

f.ROSS_STREAM_time_usec = ProtoField.new("time_usec (uint64_t) [us]", "mavlink_proto.ROSS_STREAM_time_usec", ftypes.UINT64, nil)
f.ROSS_STREAM_azimuth = ProtoField.new("azimuth (float) [rad]", "mavlink_proto.ROSS_STREAM_azimuth", ftypes.FLOAT, nil)
f.ROSS_STREAM_gain = ProtoField.new("gain (float) [dB]", "mavlink_proto.ROSS_STREAM_gain", ftypes.FLOAT, nil)
f.ROSS_STREAM_rate = ProtoField.new("rate (uint32_t) [Hz]", "mavlink_proto.ROSS_STREAM_rate", ftypes.UINT32, nil)
f.ROSS_STREAM_lost = ProtoField.new("lost (uint32_t)", "mavlink_proto.ROSS_STREAM_lost", ftypes.UINT32, nil)
f.ROSS_STREAM_packets_lost = ProtoField.new("packets_lost (uint32_t)", "mavlink_proto.ROSS_STREAM_packets_lost", ftypes.UINT32, nil)
f.ROSS_STREAM_port = ProtoField.new("port (uint16_t)", "mavlink_proto.ROSS_STREAM_port", ftypes.UINT16, nil)
f.ROSS_STREAM_delay = ProtoField.new("delay (uint16_t) [ms]", "mavlink_proto.ROSS_STREAM_delay", ftypes.UINT16, nil)
f.ROSS_STREAM_number = ProtoField.new("number (uint8_t)", "mavlink_proto.ROSS_STREAM_number", ftypes.UINT8, nil)
f.ROSS_STREAM_count = ProtoField.new("count (uint8_t)", "mavlink_proto.ROSS_STREAM_count", ftypes.UINT8, nil)
f.ROSS_STREAM_selection = ProtoField.new("selection (ROSS_SELECTION)", "mavlink_proto.ROSS_STREAM_selection", ftypes.UINT8, enumEntryName.ROSS_SELECTION)
f.ROSS_STREAM_source = ProtoField.new("source (uint8_t)", "mavlink_proto.ROSS_STREAM_source", ftypes.UINT8, nil)
f.ROSS_STREAM_group = ProtoField.new("group (uint8_t)", "mavlink_proto.ROSS_STREAM_group", ftypes.UINT8, nil)
f.ROSS_STREAM_listeners = ProtoField.new("listeners (uint8_t)", "mavlink_proto.ROSS_STREAM_listeners", ftypes.UINT8, nil)
f.ROSS_STREAM_flags = ProtoField.new("flags (ROSS_STREAM_FLAGS)", "mavlink_proto.ROSS_STREAM_flags", ftypes.UINT8, nil, base.HEX_DEC)
f.ROSS_STREAM_flags_flagROSS_STREAM_FLAGS_ON = ProtoField.bool("mavlink_proto.ROSS_STREAM_flags.ROSS_STREAM_FLAGS_ON", "ROSS_STREAM_FLAGS_ON", 8, nil, 1)
f.ROSS_STREAM_flags_flagROSS_STREAM_FLAGS_FAULT = ProtoField.bool("mavlink_proto.ROSS_STREAM_flags.ROSS_STREAM_FLAGS_FAULT", "ROSS_STREAM_FLAGS_FAULT", 8, nil, 2)
f.ROSS_STREAM_flags_flagROSS_STREAM_FLAGS_MUTED = ProtoField.bool("mavlink_proto.ROSS_STREAM_flags.ROSS_STREAM_FLAGS_MUTED", "ROSS_STREAM_FLAGS_MUTED", 8, nil, 4)
f.ROSS_STREAM_flags_flagROSS_STREAM_FLAGS_RECORDS = ProtoField.bool("mavlink_proto.ROSS_STREAM_flags.ROSS_STREAM_FLAGS_RECORDS", "ROSS_STREAM_FLAGS_RECORDS", 8, nil, 8)
f.ROSS_STREAM_flags_flagROSS_STREAM_FLAGS_SEPARATED = ProtoField.bool("mavlink_proto.ROSS_STREAM_flags.ROSS_STREAM_FLAGS_SEPARATED", "ROSS_STREAM_FLAGS_SEPARATED", 8, nil, 16)
f.ROSS_STREAM_frame = ProtoField.new("frame (ROSS_FRAME)", "mavlink_proto.ROSS_STREAM_frame", ftypes.UINT8, enumEntryName.ROSS_FRAME)
f.ROSS_STREAM_codec = ProtoField.new("codec (ROSS_CODEC)", "mavlink_proto.ROSS_STREAM_codec", ftypes.UINT8, enumEntryName.ROSS_CODEC)
f.ROSS_STREAM_level = ProtoField.new("level (int8_t) [dB]", "mavlink_proto.ROSS_STREAM_level", ftypes.INT8, nil)
f.ROSS_STREAM_sink = ProtoField.new("sink (char)", "mavlink_proto.ROSS_STREAM_sink", ftypes.STRING, nil)
f.ROSS_STREAM_address = ProtoField.new("address (char)", "mavlink_proto.ROSS_STREAM_address", ftypes.STRING, nil)
f.ROSS_STREAM_detail = ProtoField.new("detail (char)", "mavlink_proto.ROSS_STREAM_detail", ftypes.STRING, nil)

f.COMMAND_CANCEL_target_system = ProtoField.new("target_system (uint8_t)", "mavlink_proto.COMMAND_CANCEL_target_system", ftypes.UINT8, nil)
f.COMMAND_CANCEL_target_component = ProtoField.new("target_component (uint8_t)", "mavlink_proto.COMMAND_CANCEL_target_component", ftypes.UINT8, nil)
f.COMMAND_CANCEL_command = ProtoField.new("command (uint16_t)", "mavlink_proto.COMMAND_CANCEL_command", ftypes.UINT16, nil)

f.TIMESYNC_tc1 = ProtoField.new("tc1 (int64_t) [ns]", "mavlink_proto.TIMESYNC_tc1", ftypes.INT64, nil)
f.TIMESYNC_ts1 = ProtoField.new("ts1 (int64_t) [ns]", "mavlink_proto.TIMESYNC_ts1", ftypes.INT64, nil)
f.TIMESYNC_target_system = ProtoField.new("target_system (uint8_t)", "mavlink_proto.TIMESYNC_target_system", ftypes.UINT8, nil)
f.TIMESYNC_target_component = ProtoField.new("target_component (uint8_t)", "mavlink_proto.TIMESYNC_target_component", ftypes.UINT8, nil)

f.RPM_rpm1 = ProtoField.new("rpm1 (float) [rpm]", "mavlink_proto.RPM_rpm1", ftypes.FLOAT, nil)
f.RPM_rpm2 = ProtoField.new("rpm2 (float) [rpm]", "mavlink_proto.RPM_rpm2", ftypes.FLOAT, nil)

f.ESC_STATUS_index = ProtoField.new("index (uint8_t)", "mavlink_proto.ESC_STATUS_index", ftypes.UINT8, nil)
f.ESC_STATUS_time_usec = ProtoField.new("time_usec (uint64_t) [us]", "mavlink_proto.ESC_STATUS_time_usec", ftypes.UINT64, nil)
for i = 0, 3 do
    f["ESC_STATUS_rpm_"..i] = ProtoField.new("rpm["..i.."] (int32_t) [rpm]", "mavlink_proto.ESC_STATUS_rpm_"..i, ftypes.INT32, nil)
end
for i = 0, 3 do
    f["ESC_STATUS_voltage_"..i] = ProtoField.new("voltage["..i.."] (float) [V]", "mavlink_proto.ESC_STATUS_voltage_"..i, ftypes.FLOAT, nil)
end
for i = 0, 3 do
    f["ESC_STATUS_current_"..i] = ProtoField.new("current["..i.."] (float) [A]", "mavlink_proto.ESC_STATUS_current_"..i, ftypes.FLOAT, nil)
end

f.PROTOCOL_VERSION_version = ProtoField.new("version (uint16_t)", "mavlink_proto.PROTOCOL_VERSION_version", ftypes.UINT16, nil)
f.PROTOCOL_VERSION_min_version = ProtoField.new("min_version (uint16_t)", "mavlink_proto.PROTOCOL_VERSION_min_version", ftypes.UINT16, nil)
f.PROTOCOL_VERSION_max_version = ProtoField.new("max_version (uint16_t)", "mavlink_proto.PROTOCOL_VERSION_max_version", ftypes.UINT16, nil)
for i = 0, 7 do
    f["PROTOCOL_VERSION_spec_version_hash_"..i] = ProtoField.new("spec_version_hash["..i.."] (uint8_t)", "mavlink_proto.PROTOCOL_VERSION_spec_version_hash_"..i, ftypes.UINT8, nil)
end
for i = 0, 7 do
    f["PROTOCOL_VERSION_library_version_hash_"..i] = ProtoField.new("library_version_hash["..i.."] (uint8_t)", "mavlink_proto.PROTOCOL_VERSION_library_version_hash_"..i, ftypes.UINT8, nil)
end

f.COMPONENT_INFORMATION_BASIC_time_boot_ms = ProtoField.new("time_boot_ms (uint32_t) [ms]", "mavlink_proto.COMPONENT_INFORMATION_BASIC_time_boot_ms", ftypes.UINT32, nil)
f.COMPONENT_INFORMATION_BASIC_capabilities = ProtoField.new("capabilities (uint64_t)", "mavlink_proto.COMPONENT_INFORMATION_BASIC_capabilities", ftypes.UINT64, nil)
f.COMPONENT_INFORMATION_BASIC_time_manufacture_s = ProtoField.new("time_manufacture_s (uint32_t) [s]", "mavlink_proto.COMPONENT_INFORMATION_BASIC_time_manufacture_s", ftypes.UINT32, nil)
f.COMPONENT_INFORMATION_BASIC_vendor_name = ProtoField.new("vendor_name (char)", "mavlink_proto.COMPONENT_INFORMATION_BASIC_vendor_name", ftypes.STRING, nil)
f.COMPONENT_INFORMATION_BASIC_model_name = ProtoField.new("model_name (char)", "mavlink_proto.COMPONENT_INFORMATION_BASIC_model_name", ftypes.STRING, nil)
f.COMPONENT_INFORMATION_BASIC_software_version = ProtoField.new("software_version (char)", "mavlink_proto.COMPONENT_INFORMATION_BASIC_software_version", ftypes.STRING, nil)
f.COMPONENT_INFORMATION_BASIC_hardware_version = ProtoField.new("hardware_version (char)", "mavlink_proto.COMPONENT_INFORMATION_BASIC_hardware_version", ftypes.STRING, nil)
f.COMPONENT_INFORMATION_BASIC_serial_number = ProtoField.new("serial_number (char)", "mavlink_proto.COMPONENT_INFORMATION_BASIC_serial_number", ftypes.STRING, nil)

f.COMPONENT_METADATA_time_boot_ms = ProtoField.new("time_boot_ms (uint32_t) [ms]", "mavlink_proto.COMPONENT_METADATA_time_boot_ms", ftypes.UINT32, nil)
f.COMPONENT_METADATA_file_crc = ProtoField.new("file_crc (uint32_t)", "mavlink_proto.COMPONENT_METADATA_file_crc", ftypes.UINT32, nil)
f.COMPONENT_METADATA_uri = ProtoField.new("uri (char)", "mavlink_proto.COMPONENT_METADATA_uri", ftypes.STRING, nil)

f.CURRENT_MODE_standard_mode = ProtoField.new("standard_mode (uint8_t)", "mavlink_proto.CURRENT_MODE_standard_mode", ftypes.UINT8, nil)
f.CURRENT_MODE_custom_mode = ProtoField.new("custom_mode (uint32_t)", "mavlink_proto.CURRENT_MODE_custom_mode", ftypes.UINT32, nil)
f.CURRENT_MODE_intended_custom_mode = ProtoField.new("intended_custom_mode (uint32_t)", "mavlink_proto.CURRENT_MODE_intended_custom_mode", ftypes.UINT32, nil)

for i = 0, 3 do
    f["ESC_TELEMETRY_1_TO_4_temperature_"..i] = ProtoField.new("temperature["..i.."] (uint8_t) [degC]", "mavlink_proto.ESC_TELEMETRY_1_TO_4_temperature_"..i, ftypes.UINT8, nil)
end
for i = 0, 3 do
    f["ESC_TELEMETRY_1_TO_4_voltage_"..i] = ProtoField.new("voltage["..i.."] (uint16_t) [cV]", "mavlink_proto.ESC_TELEMETRY_1_TO_4_voltage_"..i, ftypes.UINT16, nil)
end
for i = 0, 3 do
    f["ESC_TELEMETRY_1_TO_4_current_"..i] = ProtoField.new("current["..i.."] (uint16_t) [cA]", "mavlink_proto.ESC_TELEMETRY_1_TO_4_current_"..i, ftypes.UINT16, nil)
end
for i = 0, 3 do
    f["ESC_TELEMETRY_1_TO_4_totalcurrent_"..i] = ProtoField.new("totalcurrent["..i.."] (uint16_t) [mAh]", "mavlink_proto.ESC_TELEMETRY_1_TO_4_totalcurrent_"..i, ftypes.UINT16, nil)
end
for i = 0, 3 do
    f["ESC_TELEMETRY_1_TO_4_rpm_"..i] = ProtoField.new("rpm["..i.."] (uint16_t) [rpm]", "mavlink_proto.ESC_TELEMETRY_1_TO_4_rpm_"..i, ftypes.UINT16, nil)
end
for i = 0, 3 do
    f["ESC_TELEMETRY_1_TO_4_count_"..i] = ProtoField.new("count["..i.."] (uint16_t)", "mavlink_proto.ESC_TELEMETRY_1_TO_4_count_"..i, ftypes.UINT16, nil)
end

for i = 0, 3 do
    f["ESC_TELEMETRY_5_TO_8_temperature_"..i] = ProtoField.new("temperature["..i.."] (uint8_t) [degC]", "mavlink_proto.ESC_TELEMETRY_5_TO_8_temperature_"..i, ftypes.UINT8, nil)
end
for i = 0, 3 do
    f["ESC_TELEMETRY_5_TO_8_voltage_"..i] = ProtoField.new("voltage["..i.."] (uint16_t) [cV]", "mavlink_proto.ESC_TELEMETRY_5_TO_8_voltage_"..i, ftypes.UINT16, nil)
end
for i = 0, 3 do
    f["ESC_TELEMETRY_5_TO_8_current_"..i] = ProtoField.new("current["..i.."] (uint16_t) [cA]", "mavlink_proto.ESC_TELEMETRY_5_TO_8_current_"..i, ftypes.UINT16, nil)
end
for i = 0, 3 do
    f["ESC_TELEMETRY_5_TO_8_totalcurrent_"..i] = ProtoField.new("totalcurrent["..i.."] (uint16_t) [mAh]", "mavlink_proto.ESC_TELEMETRY_5_TO_8_totalcurrent_"..i, ftypes.UINT16, nil)
end
for i = 0, 3 do
    f["ESC_TELEMETRY_5_TO_8_rpm_"..i] = ProtoField.new("rpm["..i.."] (uint16_t) [rpm]", "mavlink_proto.ESC_TELEMETRY_5_TO_8_rpm_"..i, ftypes.UINT16, nil)
end
for i = 0, 3 do
    f["ESC_TELEMETRY_5_TO_8_count_"..i] = ProtoField.new("count["..i.."] (uint16_t)", "mavlink_proto.ESC_TELEMETRY_5_TO_8_count_"..i, ftypes.UINT16, nil)
end

for i = 0, 3 do
    f["ESC_TELEMETRY_9_TO_12_temperature_"..i] = ProtoField.new("temperature["..i.."] (uint8_t) [degC]", "mavlink_proto.ESC_TELEMETRY_9_TO_12_temperature_"..i, ftypes.UINT8, nil)
end
for i = 0, 3 do
    f["ESC_TELEMETRY_9_TO_12_voltage_"..i] = ProtoField.new("voltage["..i.."] (uint16_t) [cV]", "mavlink_proto.ESC_TELEMETRY_9_TO_12_voltage_"..i, ftypes.UINT16, nil)
end
for i = 0, 3 do
    f["ESC_TELEMETRY_9_TO_12_current_"..i] = ProtoField.new("current["..i.."] (uint16_t) [cA]", "mavlink_proto.ESC_TELEMETRY_9_TO_12_current_"..i, ftypes.UINT16, nil)
end
for i = 0, 3 do
    f["ESC_TELEMETRY_9_TO_12_totalcurrent_"..i] = ProtoField.new("totalcurrent["..i.."] (uint16_t) [mAh]", "mavlink_proto.ESC_TELEMETRY_9_TO_12_totalcurrent_"..i, ftypes.UINT16, nil)
end
for i = 0, 3 do
    f["ESC_TELEMETRY_9_TO_12_rpm_"..i] = ProtoField.new("rpm["..i.."] (uint16_t) [rpm]", "mavlink_proto.ESC_TELEMETRY_9_TO_12_rpm_"..i, ftypes.UINT16, nil)
end
for i = 0, 3 do
    f["ESC_TELEMETRY_9_TO_12_count_"..i] = ProtoField.new("count["..i.."] (uint16_t)", "mavlink_proto.ESC_TELEMETRY_9_TO_12_count_"..i, ftypes.UINT16, nil)
end

f.HEARTBEAT_type = ProtoField.new("type (MAV_TYPE)", "mavlink_proto.HEARTBEAT_type", ftypes.UINT8, enumEntryName.MAV_TYPE)
f.HEARTBEAT_autopilot = ProtoField.new("autopilot (MAV_AUTOPILOT)", "mavlink_proto.HEARTBEAT_autopilot", ftypes.UINT8, enumEntryName.MAV_AUTOPILOT)
f.HEARTBEAT_base_mode = ProtoField.new("base_mode (MAV_MODE_FLAG)", "mavlink_proto.HEARTBEAT_base_mode", ftypes.UINT8, nil, base.HEX_DEC)
f.HEARTBEAT_base_mode_flagMAV_MODE_FLAG_CUSTOM_MODE_ENABLED = ProtoField.bool("mavlink_proto.HEARTBEAT_base_mode.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED", "MAV_MODE_FLAG_CUSTOM_MODE_ENABLED", 8, nil, 1)
f.HEARTBEAT_base_mode_flagMAV_MODE_FLAG_TEST_ENABLED = ProtoField.bool("mavlink_proto.HEARTBEAT_base_mode.MAV_MODE_FLAG_TEST_ENABLED", "MAV_MODE_FLAG_TEST_ENABLED", 8, nil, 2)
f.HEARTBEAT_base_mode_flagMAV_MODE_FLAG_AUTO_ENABLED = ProtoField.bool("mavlink_proto.HEARTBEAT_base_mode.MAV_MODE_FLAG_AUTO_ENABLED", "MAV_MODE_FLAG_AUTO_ENABLED", 8, nil, 4)
f.HEARTBEAT_base_mode_flagMAV_MODE_FLAG_GUIDED_ENABLED = ProtoField.bool("mavlink_proto.HEARTBEAT_base_mode.MAV_MODE_FLAG_GUIDED_ENABLED", "MAV_MODE_FLAG_GUIDED_ENABLED", 8, nil, 8)
f.HEARTBEAT_base_mode_flagMAV_MODE_FLAG_STABILIZE_ENABLED = ProtoField.bool("mavlink_proto.HEARTBEAT_base_mode.MAV_MODE_FLAG_STABILIZE_ENABLED", "MAV_MODE_FLAG_STABILIZE_ENABLED", 8, nil, 16)
f.HEARTBEAT_base_mode_flagMAV_MODE_FLAG_HIL_ENABLED = ProtoField.bool("mavlink_proto.HEARTBEAT_base_mode.MAV_MODE_FLAG_HIL_ENABLED", "MAV_MODE_FLAG_HIL_ENABLED", 8, nil, 32)
f.HEARTBEAT_base_mode_flagMAV_MODE_FLAG_MANUAL_INPUT_ENABLED = ProtoField.bool("mavlink_proto.HEARTBEAT_base_mode.MAV_MODE_FLAG_MANUAL_INPUT_ENABLED", "MAV_MODE_FLAG_MANUAL_INPUT_ENABLED", 8, nil, 64)
f.HEARTBEAT_base_mode_flagMAV_MODE_FLAG_SAFETY_ARMED = ProtoField.bool("mavlink_proto.HEARTBEAT_base_mode.MAV_MODE_FLAG_SAFETY_ARMED", "MAV_MODE_FLAG_SAFETY_ARMED", 8, nil, 128)
f.HEARTBEAT_custom_mode = ProtoField.new("custom_mode (uint32_t)", "mavlink_proto.HEARTBEAT_custom_mode", ftypes.UINT32, nil)
f.HEARTBEAT_system_status = ProtoField.new("system_status (MAV_STATE)", "mavlink_proto.HEARTBEAT_system_status", ftypes.UINT8, enumEntryName.MAV_STATE)
f.HEARTBEAT_mavlink_version = ProtoField.new("mavlink_version (uint8_t)", "mavlink_proto.HEARTBEAT_mavlink_version", ftypes.UINT8, nil)

f.GLOBAL_POSITION_INT_time_boot_ms = ProtoField.new("time_boot_ms (uint32_t) [ms]", "mavlink_proto.GLOBAL_POSITION_INT_time_boot_ms", ftypes.UINT32, nil)
f.GLOBAL_POSITION_INT_lat = ProtoField.new("lat (int32_t) [degE7]", "mavlink_proto.GLOBAL_POSITION_INT_lat", ftypes.INT32, nil)
f.GLOBAL_POSITION_INT_lon = ProtoField.new("lon (int32_t) [degE7]", "mavlink_proto.GLOBAL_POSITION_INT_lon", ftypes.INT32, nil)
f.GLOBAL_POSITION_INT_alt = ProtoField.new("alt (int32_t) [mm]", "mavlink_proto.GLOBAL_POSITION_INT_alt", ftypes.INT32, nil)
f.GLOBAL_POSITION_INT_relative_alt = ProtoField.new("relative_alt (int32_t) [mm]", "mavlink_proto.GLOBAL_POSITION_INT_relative_alt", ftypes.INT32, nil)
f.GLOBAL_POSITION_INT_vx = ProtoField.new("vx (int16_t) [cm/s]", "mavlink_proto.GLOBAL_POSITION_INT_vx", ftypes.INT16, nil)
f.GLOBAL_POSITION_INT_vy = ProtoField.new("vy (int16_t) [cm/s]", "mavlink_proto.GLOBAL_POSITION_INT_vy", ftypes.INT16, nil)
f.GLOBAL_POSITION_INT_vz = ProtoField.new("vz (int16_t) [cm/s]", "mavlink_proto.GLOBAL_POSITION_INT_vz", ftypes.INT16, nil)
f.GLOBAL_POSITION_INT_hdg = ProtoField.new("hdg (uint16_t) [cdeg]", "mavlink_proto.GLOBAL_POSITION_INT_hdg", ftypes.UINT16, nil)

f.AUTOPILOT_VERSION_capabilities = ProtoField.new("capabilities (MAV_PROTOCOL_CAPABILITY)", "mavlink_proto.AUTOPILOT_VERSION_capabilities", ftypes.UINT64, nil, base.HEX_DEC)
f.AUTOPILOT_VERSION_capabilities_flagMAV_PROTOCOL_CAPABILITY_MISSION_FLOAT = ProtoField.bool("mavlink_proto.AUTOPILOT_VERSION_capabilities.MAV_PROTOCOL_CAPABILITY_MISSION_FLOAT", "MAV_PROTOCOL_CAPABILITY_MISSION_FLOAT", 24, nil, 1)
f.AUTOPILOT_VERSION_capabilities_flagMAV_PROTOCOL_CAPABILITY_PARAM_FLOAT = ProtoField.bool("mavlink_proto.AUTOPILOT_VERSION_capabilities.MAV_PROTOCOL_CAPABILITY_PARAM_FLOAT", "MAV_PROTOCOL_CAPABILITY_PARAM_FLOAT", 24, nil, 2)
f.AUTOPILOT_VERSION_capabilities_flagMAV_PROTOCOL_CAPABILITY_MISSION_INT = ProtoField.bool("mavlink_proto.AUTOPILOT_VERSION_capabilities.MAV_PROTOCOL_CAPABILITY_MISSION_INT", "MAV_PROTOCOL_CAPABILITY_MISSION_INT", 24, nil, 4)
f.AUTOPILOT_VERSION_capabilities_flagMAV_PROTOCOL_CAPABILITY_COMMAND_INT = ProtoField.bool("mavlink_proto.AUTOPILOT_VERSION_capabilities.MAV_PROTOCOL_CAPABILITY_COMMAND_INT", "MAV_PROTOCOL_CAPABILITY_COMMAND_INT", 24, nil, 8)
f.AUTOPILOT_VERSION_capabilities_flagMAV_PROTOCOL_CAPABILITY_PARAM_ENCODE_BYTEWISE = ProtoField.bool("mavlink_proto.AUTOPILOT_VERSION_capabilities.MAV_PROTOCOL_CAPABILITY_PARAM_ENCODE_BYTEWISE", "MAV_PROTOCOL_CAPABILITY_PARAM_ENCODE_BYTEWISE", 24, nil, 16)
f.AUTOPILOT_VERSION_capabilities_flagMAV_PROTOCOL_CAPABILITY_FTP = ProtoField.bool("mavlink_proto.AUTOPILOT_VERSION_capabilities.MAV_PROTOCOL_CAPABILITY_FTP", "MAV_PROTOCOL_CAPABILITY_FTP", 24, nil, 32)
f.AUTOPILOT_VERSION_capabilities_flagMAV_PROTOCOL_CAPABILITY_SET_ATTITUDE_TARGET = ProtoField.bool("mavlink_proto.AUTOPILOT_VERSION_capabilities.MAV_PROTOCOL_CAPABILITY_SET_ATTITUDE_TARGET", "MAV_PROTOCOL_CAPABILITY_SET_ATTITUDE_TARGET", 24, nil, 64)
f.AUTOPILOT_VERSION_capabilities_flagMAV_PROTOCOL_CAPABILITY_SET_POSITION_TARGET_LOCAL_NED = ProtoField.bool("mavlink_proto.AUTOPILOT_VERSION_capabilities.MAV_PROTOCOL_CAPABILITY_SET_POSITION_TARGET_LOCAL_NED", "MAV_PROTOCOL_CAPABILITY_SET_POSITION_TARGET_LOCAL_NED", 24, nil, 128)
f.AUTOPILOT_VERSION_capabilities_flagMAV_PROTOCOL_CAPABILITY_SET_POSITION_TARGET_GLOBAL_INT = ProtoField.bool("mavlink_proto.AUTOPILOT_VERSION_capabilities.MAV_PROTOCOL_CAPABILITY_SET_POSITION_TARGET_GLOBAL_INT", "MAV_PROTOCOL_CAPABILITY_SET_POSITION_TARGET_GLOBAL_INT", 24, nil, 256)
f.AUTOPILOT_VERSION_capabilities_flagMAV_PROTOCOL_CAPABILITY_TERRAIN = ProtoField.bool("mavlink_proto.AUTOPILOT_VERSION_capabilities.MAV_PROTOCOL_CAPABILITY_TERRAIN", "MAV_PROTOCOL_CAPABILITY_TERRAIN", 24, nil, 512)
f.AUTOPILOT_VERSION_capabilities_flagMAV_PROTOCOL_CAPABILITY_RESERVED3 = ProtoField.bool("mavlink_proto.AUTOPILOT_VERSION_capabilities.MAV_PROTOCOL_CAPABILITY_RESERVED3", "MAV_PROTOCOL_CAPABILITY_RESERVED3", 24, nil, 1024)
f.AUTOPILOT_VERSION_capabilities_flagMAV_PROTOCOL_CAPABILITY_FLIGHT_TERMINATION = ProtoField.bool("mavlink_proto.AUTOPILOT_VERSION_capabilities.MAV_PROTOCOL_CAPABILITY_FLIGHT_TERMINATION", "MAV_PROTOCOL_CAPABILITY_FLIGHT_TERMINATION", 24, nil, 2048)
f.AUTOPILOT_VERSION_capabilities_flagMAV_PROTOCOL_CAPABILITY_COMPASS_CALIBRATION = ProtoField.bool("mavlink_proto.AUTOPILOT_VERSION_capabilities.MAV_PROTOCOL_CAPABILITY_COMPASS_CALIBRATION", "MAV_PROTOCOL_CAPABILITY_COMPASS_CALIBRATION", 24, nil, 4096)
f.AUTOPILOT_VERSION_capabilities_flagMAV_PROTOCOL_CAPABILITY_MAVLINK2 = ProtoField.bool("mavlink_proto.AUTOPILOT_VERSION_capabilities.MAV_PROTOCOL_CAPABILITY_MAVLINK2", "MAV_PROTOCOL_CAPABILITY_MAVLINK2", 24, nil, 8192)
f.AUTOPILOT_VERSION_capabilities_flagMAV_PROTOCOL_CAPABILITY_MISSION_FENCE = ProtoField.bool("mavlink_proto.AUTOPILOT_VERSION_capabilities.MAV_PROTOCOL_CAPABILITY_MISSION_FENCE", "MAV_PROTOCOL_CAPABILITY_MISSION_FENCE", 24, nil, 16384)
f.AUTOPILOT_VERSION_capabilities_flagMAV_PROTOCOL_CAPABILITY_MISSION_RALLY = ProtoField.bool("mavlink_proto.AUTOPILOT_VERSION_capabilities.MAV_PROTOCOL_CAPABILITY_MISSION_RALLY", "MAV_PROTOCOL_CAPABILITY_MISSION_RALLY", 24, nil, 32768)
f.AUTOPILOT_VERSION_capabilities_flagMAV_PROTOCOL_CAPABILITY_RESERVED2 = ProtoField.bool("mavlink_proto.AUTOPILOT_VERSION_capabilities.MAV_PROTOCOL_CAPABILITY_RESERVED2", "MAV_PROTOCOL_CAPABILITY_RESERVED2", 24, nil, 65536)
f.AUTOPILOT_VERSION_capabilities_flagMAV_PROTOCOL_CAPABILITY_PARAM_ENCODE_C_CAST = ProtoField.bool("mavlink_proto.AUTOPILOT_VERSION_capabilities.MAV_PROTOCOL_CAPABILITY_PARAM_ENCODE_C_CAST", "MAV_PROTOCOL_CAPABILITY_PARAM_ENCODE_C_CAST", 24, nil, 131072)
f.AUTOPILOT_VERSION_capabilities_flagMAV_PROTOCOL_CAPABILITY_COMPONENT_IMPLEMENTS_GIMBAL_MANAGER = ProtoField.bool("mavlink_proto.AUTOPILOT_VERSION_capabilities.MAV_PROTOCOL_CAPABILITY_COMPONENT_IMPLEMENTS_GIMBAL_MANAGER", "MAV_PROTOCOL_CAPABILITY_COMPONENT_IMPLEMENTS_GIMBAL_MANAGER", 24, nil, 262144)
f.AUTOPILOT_VERSION_capabilities_flagMAV_PROTOCOL_CAPABILITY_COMPONENT_ACCEPTS_GCS_CONTROL = ProtoField.bool("mavlink_proto.AUTOPILOT_VERSION_capabilities.MAV_PROTOCOL_CAPABILITY_COMPONENT_ACCEPTS_GCS_CONTROL", "MAV_PROTOCOL_CAPABILITY_COMPONENT_ACCEPTS_GCS_CONTROL", 24, nil, 524288)
f.AUTOPILOT_VERSION_capabilities_flagMAV_PROTOCOL_CAPABILITY_GRIPPER = ProtoField.bool("mavlink_proto.AUTOPILOT_VERSION_capabilities.MAV_PROTOCOL_CAPABILITY_GRIPPER", "MAV_PROTOCOL_CAPABILITY_GRIPPER", 24, nil, 1048576)
f.AUTOPILOT_VERSION_flight_sw_version = ProtoField.new("flight_sw_version (uint32_t)", "mavlink_proto.AUTOPILOT_VERSION_flight_sw_version", ftypes.UINT32, nil)
f.AUTOPILOT_VERSION_middleware_sw_version = ProtoField.new("middleware_sw_version (uint32_t)", "mavlink_proto.AUTOPILOT_VERSION_middleware_sw_version", ftypes.UINT32, nil)
f.AUTOPILOT_VERSION_os_sw_version = ProtoField.new("os_sw_version (uint32_t)", "mavlink_proto.AUTOPILOT_VERSION_os_sw_version", ftypes.UINT32, nil)
f.AUTOPILOT_VERSION_board_version = ProtoField.new("board_version (uint32_t)", "mavlink_proto.AUTOPILOT_VERSION_board_version", ftypes.UINT32, nil)
for i = 0, 7 do
    f["AUTOPILOT_VERSION_flight_custom_version_"..i] = ProtoField.new("flight_custom_version["..i.."] (uint8_t)", "mavlink_proto.AUTOPILOT_VERSION_flight_custom_version_"..i, ftypes.UINT8, nil)
end
for i = 0, 7 do
    f["AUTOPILOT_VERSION_middleware_custom_version_"..i] = ProtoField.new("middleware_custom_version["..i.."] (uint8_t)", "mavlink_proto.AUTOPILOT_VERSION_middleware_custom_version_"..i, ftypes.UINT8, nil)
end
for i = 0, 7 do
    f["AUTOPILOT_VERSION_os_custom_version_"..i] = ProtoField.new("os_custom_version["..i.."] (uint8_t)", "mavlink_proto.AUTOPILOT_VERSION_os_custom_version_"..i, ftypes.UINT8, nil)
end
f.AUTOPILOT_VERSION_vendor_id = ProtoField.new("vendor_id (uint16_t)", "mavlink_proto.AUTOPILOT_VERSION_vendor_id", ftypes.UINT16, nil)
f.AUTOPILOT_VERSION_product_id = ProtoField.new("product_id (uint16_t)", "mavlink_proto.AUTOPILOT_VERSION_product_id", ftypes.UINT16, nil)
f.AUTOPILOT_VERSION_uid = ProtoField.new("uid (uint64_t)", "mavlink_proto.AUTOPILOT_VERSION_uid", ftypes.UINT64, nil)
for i = 0, 17 do
    f["AUTOPILOT_VERSION_uid2_"..i] = ProtoField.new("uid2["..i.."] (uint8_t)", "mavlink_proto.AUTOPILOT_VERSION_uid2_"..i, ftypes.UINT8, nil)
end

f.SYSTEM_TIME_time_unix_usec = ProtoField.new("time_unix_usec (uint64_t) [us]", "mavlink_proto.SYSTEM_TIME_time_unix_usec", ftypes.UINT64, nil)
f.SYSTEM_TIME_time_boot_ms = ProtoField.new("time_boot_ms (uint32_t) [ms]", "mavlink_proto.SYSTEM_TIME_time_boot_ms", ftypes.UINT32, nil)

f.PARAM_REQUEST_READ_target_system = ProtoField.new("target_system (uint8_t)", "mavlink_proto.PARAM_REQUEST_READ_target_system", ftypes.UINT8, nil)
f.PARAM_REQUEST_READ_target_component = ProtoField.new("target_component (uint8_t)", "mavlink_proto.PARAM_REQUEST_READ_target_component", ftypes.UINT8, nil)
f.PARAM_REQUEST_READ_param_id = ProtoField.new("param_id (char)", "mavlink_proto.PARAM_REQUEST_READ_param_id", ftypes.STRING, nil)
f.PARAM_REQUEST_READ_param_index = ProtoField.new("param_index (int16_t)", "mavlink_proto.PARAM_REQUEST_READ_param_index", ftypes.INT16, nil)

f.PARAM_REQUEST_LIST_target_system = ProtoField.new("target_system (uint8_t)", "mavlink_proto.PARAM_REQUEST_LIST_target_system", ftypes.UINT8, nil)
f.PARAM_REQUEST_LIST_target_component = ProtoField.new("target_component (uint8_t)", "mavlink_proto.PARAM_REQUEST_LIST_target_component", ftypes.UINT8, nil)

f.PARAM_VALUE_param_id = ProtoField.new("param_id (char)", "mavlink_proto.PARAM_VALUE_param_id", ftypes.STRING, nil)
f.PARAM_VALUE_param_value = ProtoField.new("param_value (float)", "mavlink_proto.PARAM_VALUE_param_value", ftypes.FLOAT, nil)
f.PARAM_VALUE_param_type = ProtoField.new("param_type (MAV_PARAM_TYPE)", "mavlink_proto.PARAM_VALUE_param_type", ftypes.UINT8, enumEntryName.MAV_PARAM_TYPE)
f.PARAM_VALUE_param_count = ProtoField.new("param_count (uint16_t)", "mavlink_proto.PARAM_VALUE_param_count", ftypes.UINT16, nil)
f.PARAM_VALUE_param_index = ProtoField.new("param_index (uint16_t)", "mavlink_proto.PARAM_VALUE_param_index", ftypes.UINT16, nil)

f.PARAM_SET_target_system = ProtoField.new("target_system (uint8_t)", "mavlink_proto.PARAM_SET_target_system", ftypes.UINT8, nil)
f.PARAM_SET_target_component = ProtoField.new("target_component (uint8_t)", "mavlink_proto.PARAM_SET_target_component", ftypes.UINT8, nil)
f.PARAM_SET_param_id = ProtoField.new("param_id (char)", "mavlink_proto.PARAM_SET_param_id", ftypes.STRING, nil)
f.PARAM_SET_param_value = ProtoField.new("param_value (float)", "mavlink_proto.PARAM_SET_param_value", ftypes.FLOAT, nil)
f.PARAM_SET_param_type = ProtoField.new("param_type (MAV_PARAM_TYPE)", "mavlink_proto.PARAM_SET_param_type", ftypes.UINT8, enumEntryName.MAV_PARAM_TYPE)

f.ATTITUDE_time_boot_ms = ProtoField.new("time_boot_ms (uint32_t) [ms]", "mavlink_proto.ATTITUDE_time_boot_ms", ftypes.UINT32, nil)
f.ATTITUDE_roll = ProtoField.new("roll (float) [rad]", "mavlink_proto.ATTITUDE_roll", ftypes.FLOAT, nil)
f.ATTITUDE_pitch = ProtoField.new("pitch (float) [rad]", "mavlink_proto.ATTITUDE_pitch", ftypes.FLOAT, nil)
f.ATTITUDE_yaw = ProtoField.new("yaw (float) [rad]", "mavlink_proto.ATTITUDE_yaw", ftypes.FLOAT, nil)
f.ATTITUDE_rollspeed = ProtoField.new("rollspeed (float) [rad/s]", "mavlink_proto.ATTITUDE_rollspeed", ftypes.FLOAT, nil)
f.ATTITUDE_pitchspeed = ProtoField.new("pitchspeed (float) [rad/s]", "mavlink_proto.ATTITUDE_pitchspeed", ftypes.FLOAT, nil)
f.ATTITUDE_yawspeed = ProtoField.new("yawspeed (float) [rad/s]", "mavlink_proto.ATTITUDE_yawspeed", ftypes.FLOAT, nil)

f.ATTITUDE_QUATERNION_time_boot_ms = ProtoField.new("time_boot_ms (uint32_t) [ms]", "mavlink_proto.ATTITUDE_QUATERNION_time_boot_ms", ftypes.UINT32, nil)
f.ATTITUDE_QUATERNION_q1 = ProtoField.new("q1 (float)", "mavlink_proto.ATTITUDE_QUATERNION_q1", ftypes.FLOAT, nil)
f.ATTITUDE_QUATERNION_q2 = ProtoField.new("q2 (float)", "mavlink_proto.ATTITUDE_QUATERNION_q2", ftypes.FLOAT, nil)
f.ATTITUDE_QUATERNION_q3 = ProtoField.new("q3 (float)", "mavlink_proto.ATTITUDE_QUATERNION_q3", ftypes.FLOAT, nil)
f.ATTITUDE_QUATERNION_q4 = ProtoField.new("q4 (float)", "mavlink_proto.ATTITUDE_QUATERNION_q4", ftypes.FLOAT, nil)
f.ATTITUDE_QUATERNION_rollspeed = ProtoField.new("rollspeed (float) [rad/s]", "mavlink_proto.ATTITUDE_QUATERNION_rollspeed", ftypes.FLOAT, nil)
f.ATTITUDE_QUATERNION_pitchspeed = ProtoField.new("pitchspeed (float) [rad/s]", "mavlink_proto.ATTITUDE_QUATERNION_pitchspeed", ftypes.FLOAT, nil)
f.ATTITUDE_QUATERNION_yawspeed = ProtoField.new("yawspeed (float) [rad/s]", "mavlink_proto.ATTITUDE_QUATERNION_yawspeed", ftypes.FLOAT, nil)
for i = 0, 3 do
    f["ATTITUDE_QUATERNION_repr_offset_q_"..i] = ProtoField.new("repr_offset_q["..i.."] (float)", "mavlink_proto.ATTITUDE_QUATERNION_repr_offset_q_"..i, ftypes.FLOAT, nil)
end

f.LOCAL_POSITION_NED_time_boot_ms = ProtoField.new("time_boot_ms (uint32_t) [ms]", "mavlink_proto.LOCAL_POSITION_NED_time_boot_ms", ftypes.UINT32, nil)
f.LOCAL_POSITION_NED_x = ProtoField.new("x (float) [m]", "mavlink_proto.LOCAL_POSITION_NED_x", ftypes.FLOAT, nil)
f.LOCAL_POSITION_NED_y = ProtoField.new("y (float) [m]", "mavlink_proto.LOCAL_POSITION_NED_y", ftypes.FLOAT, nil)
f.LOCAL_POSITION_NED_z = ProtoField.new("z (float) [m]", "mavlink_proto.LOCAL_POSITION_NED_z", ftypes.FLOAT, nil)
f.LOCAL_POSITION_NED_vx = ProtoField.new("vx (float) [m/s]", "mavlink_proto.LOCAL_POSITION_NED_vx", ftypes.FLOAT, nil)
f.LOCAL_POSITION_NED_vy = ProtoField.new("vy (float) [m/s]", "mavlink_proto.LOCAL_POSITION_NED_vy", ftypes.FLOAT, nil)
f.LOCAL_POSITION_NED_vz = ProtoField.new("vz (float) [m/s]", "mavlink_proto.LOCAL_POSITION_NED_vz", ftypes.FLOAT, nil)

f.RC_CHANNELS_time_boot_ms = ProtoField.new("time_boot_ms (uint32_t) [ms]", "mavlink_proto.RC_CHANNELS_time_boot_ms", ftypes.UINT32, nil)
f.RC_CHANNELS_chancount = ProtoField.new("chancount (uint8_t)", "mavlink_proto.RC_CHANNELS_chancount", ftypes.UINT8, nil)
f.RC_CHANNELS_chan1_raw = ProtoField.new("chan1_raw (uint16_t) [us]", "mavlink_proto.RC_CHANNELS_chan1_raw", ftypes.UINT16, nil)
f.RC_CHANNELS_chan2_raw = ProtoField.new("chan2_raw (uint16_t) [us]", "mavlink_proto.RC_CHANNELS_chan2_raw", ftypes.UINT16, nil)
f.RC_CHANNELS_chan3_raw = ProtoField.new("chan3_raw (uint16_t) [us]", "mavlink_proto.RC_CHANNELS_chan3_raw", ftypes.UINT16, nil)
f.RC_CHANNELS_chan4_raw = ProtoField.new("chan4_raw (uint16_t) [us]", "mavlink_proto.RC_CHANNELS_chan4_raw", ftypes.UINT16, nil)
f.RC_CHANNELS_chan5_raw = ProtoField.new("chan5_raw (uint16_t) [us]", "mavlink_proto.RC_CHANNELS_chan5_raw", ftypes.UINT16, nil)
f.RC_CHANNELS_chan6_raw = ProtoField.new("chan6_raw (uint16_t) [us]", "mavlink_proto.RC_CHANNELS_chan6_raw", ftypes.UINT16, nil)
f.RC_CHANNELS_chan7_raw = ProtoField.new("chan7_raw (uint16_t) [us]", "mavlink_proto.RC_CHANNELS_chan7_raw", ftypes.UINT16, nil)
f.RC_CHANNELS_chan8_raw = ProtoField.new("chan8_raw (uint16_t) [us]", "mavlink_proto.RC_CHANNELS_chan8_raw", ftypes.UINT16, nil)
f.RC_CHANNELS_chan9_raw = ProtoField.new("chan9_raw (uint16_t) [us]", "mavlink_proto.RC_CHANNELS_chan9_raw", ftypes.UINT16, nil)
f.RC_CHANNELS_chan10_raw = ProtoField.new("chan10_raw (uint16_t) [us]", "mavlink_proto.RC_CHANNELS_chan10_raw", ftypes.UINT16, nil)
f.RC_CHANNELS_chan11_raw = ProtoField.new("chan11_raw (uint16_t) [us]", "mavlink_proto.RC_CHANNELS_chan11_raw", ftypes.UINT16, nil)
f.RC_CHANNELS_chan12_raw = ProtoField.new("chan12_raw (uint16_t) [us]", "mavlink_proto.RC_CHANNELS_chan12_raw", ftypes.UINT16, nil)
f.RC_CHANNELS_chan13_raw = ProtoField.new("chan13_raw (uint16_t) [us]", "mavlink_proto.RC_CHANNELS_chan13_raw", ftypes.UINT16, nil)
f.RC_CHANNELS_chan14_raw = ProtoField.new("chan14_raw (uint16_t) [us]", "mavlink_proto.RC_CHANNELS_chan14_raw", ftypes.UINT16, nil)
f.RC_CHANNELS_chan15_raw = ProtoField.new("chan15_raw (uint16_t) [us]", "mavlink_proto.RC_CHANNELS_chan15_raw", ftypes.UINT16, nil)
f.RC_CHANNELS_chan16_raw = ProtoField.new("chan16_raw (uint16_t) [us]", "mavlink_proto.RC_CHANNELS_chan16_raw", ftypes.UINT16, nil)
f.RC_CHANNELS_chan17_raw = ProtoField.new("chan17_raw (uint16_t) [us]", "mavlink_proto.RC_CHANNELS_chan17_raw", ftypes.UINT16, nil)
f.RC_CHANNELS_chan18_raw = ProtoField.new("chan18_raw (uint16_t) [us]", "mavlink_proto.RC_CHANNELS_chan18_raw", ftypes.UINT16, nil)
f.RC_CHANNELS_rssi = ProtoField.new("rssi (uint8_t)", "mavlink_proto.RC_CHANNELS_rssi", ftypes.UINT8, nil)

f.MANUAL_CONTROL_target = ProtoField.new("target (uint8_t)", "mavlink_proto.MANUAL_CONTROL_target", ftypes.UINT8, nil)
f.MANUAL_CONTROL_x = ProtoField.new("x (int16_t)", "mavlink_proto.MANUAL_CONTROL_x", ftypes.INT16, nil)
f.MANUAL_CONTROL_y = ProtoField.new("y (int16_t)", "mavlink_proto.MANUAL_CONTROL_y", ftypes.INT16, nil)
f.MANUAL_CONTROL_z = ProtoField.new("z (int16_t)", "mavlink_proto.MANUAL_CONTROL_z", ftypes.INT16, nil)
f.MANUAL_CONTROL_r = ProtoField.new("r (int16_t)", "mavlink_proto.MANUAL_CONTROL_r", ftypes.INT16, nil)
f.MANUAL_CONTROL_buttons = ProtoField.new("buttons (uint16_t)", "mavlink_proto.MANUAL_CONTROL_buttons", ftypes.UINT16, nil)
f.MANUAL_CONTROL_buttons2 = ProtoField.new("buttons2 (uint16_t)", "mavlink_proto.MANUAL_CONTROL_buttons2", ftypes.UINT16, nil)
f.MANUAL_CONTROL_enabled_extensions = ProtoField.new("enabled_extensions (uint8_t)", "mavlink_proto.MANUAL_CONTROL_enabled_extensions", ftypes.UINT8, nil)
f.MANUAL_CONTROL_s = ProtoField.new("s (int16_t)", "mavlink_proto.MANUAL_CONTROL_s", ftypes.INT16, nil)
f.MANUAL_CONTROL_t = ProtoField.new("t (int16_t)", "mavlink_proto.MANUAL_CONTROL_t", ftypes.INT16, nil)
f.MANUAL_CONTROL_aux1 = ProtoField.new("aux1 (int16_t)", "mavlink_proto.MANUAL_CONTROL_aux1", ftypes.INT16, nil)
f.MANUAL_CONTROL_aux2 = ProtoField.new("aux2 (int16_t)", "mavlink_proto.MANUAL_CONTROL_aux2", ftypes.INT16, nil)
f.MANUAL_CONTROL_aux3 = ProtoField.new("aux3 (int16_t)", "mavlink_proto.MANUAL_CONTROL_aux3", ftypes.INT16, nil)
f.MANUAL_CONTROL_aux4 = ProtoField.new("aux4 (int16_t)", "mavlink_proto.MANUAL_CONTROL_aux4", ftypes.INT16, nil)
f.MANUAL_CONTROL_aux5 = ProtoField.new("aux5 (int16_t)", "mavlink_proto.MANUAL_CONTROL_aux5", ftypes.INT16, nil)
f.MANUAL_CONTROL_aux6 = ProtoField.new("aux6 (int16_t)", "mavlink_proto.MANUAL_CONTROL_aux6", ftypes.INT16, nil)

f.COMMAND_INT_target_system = ProtoField.new("target_system (uint8_t)", "mavlink_proto.COMMAND_INT_target_system", ftypes.UINT8, nil)
f.COMMAND_INT_target_component = ProtoField.new("target_component (uint8_t)", "mavlink_proto.COMMAND_INT_target_component", ftypes.UINT8, nil)
f.COMMAND_INT_frame = ProtoField.new("frame (MAV_FRAME)", "mavlink_proto.COMMAND_INT_frame", ftypes.UINT8, enumEntryName.MAV_FRAME)
f.COMMAND_INT_command = ProtoField.new("command (MAV_CMD)", "mavlink_proto.COMMAND_INT_command", ftypes.UINT16, enumEntryName.MAV_CMD)
f.COMMAND_INT_current = ProtoField.new("current (uint8_t)", "mavlink_proto.COMMAND_INT_current", ftypes.UINT8, nil)
f.COMMAND_INT_autocontinue = ProtoField.new("autocontinue (uint8_t)", "mavlink_proto.COMMAND_INT_autocontinue", ftypes.UINT8, nil)
f.COMMAND_INT_param1 = ProtoField.new("param1 (float)", "mavlink_proto.COMMAND_INT_param1", ftypes.FLOAT, nil)
f.COMMAND_INT_param2 = ProtoField.new("param2 (float)", "mavlink_proto.COMMAND_INT_param2", ftypes.FLOAT, nil)
f.COMMAND_INT_param3 = ProtoField.new("param3 (float)", "mavlink_proto.COMMAND_INT_param3", ftypes.FLOAT, nil)
f.COMMAND_INT_param4 = ProtoField.new("param4 (float)", "mavlink_proto.COMMAND_INT_param4", ftypes.FLOAT, nil)
f.COMMAND_INT_x = ProtoField.new("x (int32_t)", "mavlink_proto.COMMAND_INT_x", ftypes.INT32, nil)
f.COMMAND_INT_y = ProtoField.new("y (int32_t)", "mavlink_proto.COMMAND_INT_y", ftypes.INT32, nil)
f.COMMAND_INT_z = ProtoField.new("z (float)", "mavlink_proto.COMMAND_INT_z", ftypes.FLOAT, nil)

f.COMMAND_LONG_target_system = ProtoField.new("target_system (uint8_t)", "mavlink_proto.COMMAND_LONG_target_system", ftypes.UINT8, nil)
f.COMMAND_LONG_target_component = ProtoField.new("target_component (uint8_t)", "mavlink_proto.COMMAND_LONG_target_component", ftypes.UINT8, nil)
f.COMMAND_LONG_command = ProtoField.new("command (MAV_CMD)", "mavlink_proto.COMMAND_LONG_command", ftypes.UINT16, enumEntryName.MAV_CMD)
f.COMMAND_LONG_confirmation = ProtoField.new("confirmation (uint8_t)", "mavlink_proto.COMMAND_LONG_confirmation", ftypes.UINT8, nil)
f.COMMAND_LONG_param1 = ProtoField.new("param1 (float)", "mavlink_proto.COMMAND_LONG_param1", ftypes.FLOAT, nil)
f.COMMAND_LONG_param2 = ProtoField.new("param2 (float)", "mavlink_proto.COMMAND_LONG_param2", ftypes.FLOAT, nil)
f.COMMAND_LONG_param3 = ProtoField.new("param3 (float)", "mavlink_proto.COMMAND_LONG_param3", ftypes.FLOAT, nil)
f.COMMAND_LONG_param4 = ProtoField.new("param4 (float)", "mavlink_proto.COMMAND_LONG_param4", ftypes.FLOAT, nil)
f.COMMAND_LONG_param5 = ProtoField.new("param5 (float)", "mavlink_proto.COMMAND_LONG_param5", ftypes.FLOAT, nil)
f.COMMAND_LONG_param6 = ProtoField.new("param6 (float)", "mavlink_proto.COMMAND_LONG_param6", ftypes.FLOAT, nil)
f.COMMAND_LONG_param7 = ProtoField.new("param7 (float)", "mavlink_proto.COMMAND_LONG_param7", ftypes.FLOAT, nil)

f.COMMAND_ACK_command = ProtoField.new("command (MAV_CMD)", "mavlink_proto.COMMAND_ACK_command", ftypes.UINT16, enumEntryName.MAV_CMD)
f.COMMAND_ACK_result = ProtoField.new("result (MAV_RESULT)", "mavlink_proto.COMMAND_ACK_result", ftypes.UINT8, enumEntryName.MAV_RESULT)
f.COMMAND_ACK_progress = ProtoField.new("progress (uint8_t)", "mavlink_proto.COMMAND_ACK_progress", ftypes.UINT8, nil)
f.COMMAND_ACK_result_param2 = ProtoField.new("result_param2 (int32_t)", "mavlink_proto.COMMAND_ACK_result_param2", ftypes.INT32, nil)
f.COMMAND_ACK_target_system = ProtoField.new("target_system (uint8_t)", "mavlink_proto.COMMAND_ACK_target_system", ftypes.UINT8, nil)
f.COMMAND_ACK_target_component = ProtoField.new("target_component (uint8_t)", "mavlink_proto.COMMAND_ACK_target_component", ftypes.UINT8, nil)

f.SET_POSITION_TARGET_LOCAL_NED_time_boot_ms = ProtoField.new("time_boot_ms (uint32_t) [ms]", "mavlink_proto.SET_POSITION_TARGET_LOCAL_NED_time_boot_ms", ftypes.UINT32, nil)
f.SET_POSITION_TARGET_LOCAL_NED_target_system = ProtoField.new("target_system (uint8_t)", "mavlink_proto.SET_POSITION_TARGET_LOCAL_NED_target_system", ftypes.UINT8, nil)
f.SET_POSITION_TARGET_LOCAL_NED_target_component = ProtoField.new("target_component (uint8_t)", "mavlink_proto.SET_POSITION_TARGET_LOCAL_NED_target_component", ftypes.UINT8, nil)
f.SET_POSITION_TARGET_LOCAL_NED_coordinate_frame = ProtoField.new("coordinate_frame (MAV_FRAME)", "mavlink_proto.SET_POSITION_TARGET_LOCAL_NED_coordinate_frame", ftypes.UINT8, enumEntryName.MAV_FRAME)
f.SET_POSITION_TARGET_LOCAL_NED_type_mask = ProtoField.new("type_mask (POSITION_TARGET_TYPEMASK)", "mavlink_proto.SET_POSITION_TARGET_LOCAL_NED_type_mask", ftypes.UINT16, nil, base.HEX_DEC)
f.SET_POSITION_TARGET_LOCAL_NED_type_mask_flagPOSITION_TARGET_TYPEMASK_X_IGNORE = ProtoField.bool("mavlink_proto.SET_POSITION_TARGET_LOCAL_NED_type_mask.POSITION_TARGET_TYPEMASK_X_IGNORE", "POSITION_TARGET_TYPEMASK_X_IGNORE", 12, nil, 1)
f.SET_POSITION_TARGET_LOCAL_NED_type_mask_flagPOSITION_TARGET_TYPEMASK_Y_IGNORE = ProtoField.bool("mavlink_proto.SET_POSITION_TARGET_LOCAL_NED_type_mask.POSITION_TARGET_TYPEMASK_Y_IGNORE", "POSITION_TARGET_TYPEMASK_Y_IGNORE", 12, nil, 2)
f.SET_POSITION_TARGET_LOCAL_NED_type_mask_flagPOSITION_TARGET_TYPEMASK_Z_IGNORE = ProtoField.bool("mavlink_proto.SET_POSITION_TARGET_LOCAL_NED_type_mask.POSITION_TARGET_TYPEMASK_Z_IGNORE", "POSITION_TARGET_TYPEMASK_Z_IGNORE", 12, nil, 4)
f.SET_POSITION_TARGET_LOCAL_NED_type_mask_flagPOSITION_TARGET_TYPEMASK_VX_IGNORE = ProtoField.bool("mavlink_proto.SET_POSITION_TARGET_LOCAL_NED_type_mask.POSITION_TARGET_TYPEMASK_VX_IGNORE", "POSITION_TARGET_TYPEMASK_VX_IGNORE", 12, nil, 8)
f.SET_POSITION_TARGET_LOCAL_NED_type_mask_flagPOSITION_TARGET_TYPEMASK_VY_IGNORE = ProtoField.bool("mavlink_proto.SET_POSITION_TARGET_LOCAL_NED_type_mask.POSITION_TARGET_TYPEMASK_VY_IGNORE", "POSITION_TARGET_TYPEMASK_VY_IGNORE", 12, nil, 16)
f.SET_POSITION_TARGET_LOCAL_NED_type_mask_flagPOSITION_TARGET_TYPEMASK_VZ_IGNORE = ProtoField.bool("mavlink_proto.SET_POSITION_TARGET_LOCAL_NED_type_mask.POSITION_TARGET_TYPEMASK_VZ_IGNORE", "POSITION_TARGET_TYPEMASK_VZ_IGNORE", 12, nil, 32)
f.SET_POSITION_TARGET_LOCAL_NED_type_mask_flagPOSITION_TARGET_TYPEMASK_AX_IGNORE = ProtoField.bool("mavlink_proto.SET_POSITION_TARGET_LOCAL_NED_type_mask.POSITION_TARGET_TYPEMASK_AX_IGNORE", "POSITION_TARGET_TYPEMASK_AX_IGNORE", 12, nil, 64)
f.SET_POSITION_TARGET_LOCAL_NED_type_mask_flagPOSITION_TARGET_TYPEMASK_AY_IGNORE = ProtoField.bool("mavlink_proto.SET_POSITION_TARGET_LOCAL_NED_type_mask.POSITION_TARGET_TYPEMASK_AY_IGNORE", "POSITION_TARGET_TYPEMASK_AY_IGNORE", 12, nil, 128)
f.SET_POSITION_TARGET_LOCAL_NED_type_mask_flagPOSITION_TARGET_TYPEMASK_AZ_IGNORE = ProtoField.bool("mavlink_proto.SET_POSITION_TARGET_LOCAL_NED_type_mask.POSITION_TARGET_TYPEMASK_AZ_IGNORE", "POSITION_TARGET_TYPEMASK_AZ_IGNORE", 12, nil, 256)
f.SET_POSITION_TARGET_LOCAL_NED_type_mask_flagPOSITION_TARGET_TYPEMASK_FORCE_SET = ProtoField.bool("mavlink_proto.SET_POSITION_TARGET_LOCAL_NED_type_mask.POSITION_TARGET_TYPEMASK_FORCE_SET", "POSITION_TARGET_TYPEMASK_FORCE_SET", 12, nil, 512)
f.SET_POSITION_TARGET_LOCAL_NED_type_mask_flagPOSITION_TARGET_TYPEMASK_YAW_IGNORE = ProtoField.bool("mavlink_proto.SET_POSITION_TARGET_LOCAL_NED_type_mask.POSITION_TARGET_TYPEMASK_YAW_IGNORE", "POSITION_TARGET_TYPEMASK_YAW_IGNORE", 12, nil, 1024)
f.SET_POSITION_TARGET_LOCAL_NED_type_mask_flagPOSITION_TARGET_TYPEMASK_YAW_RATE_IGNORE = ProtoField.bool("mavlink_proto.SET_POSITION_TARGET_LOCAL_NED_type_mask.POSITION_TARGET_TYPEMASK_YAW_RATE_IGNORE", "POSITION_TARGET_TYPEMASK_YAW_RATE_IGNORE", 12, nil, 2048)
f.SET_POSITION_TARGET_LOCAL_NED_x = ProtoField.new("x (float) [m]", "mavlink_proto.SET_POSITION_TARGET_LOCAL_NED_x", ftypes.FLOAT, nil)
f.SET_POSITION_TARGET_LOCAL_NED_y = ProtoField.new("y (float) [m]", "mavlink_proto.SET_POSITION_TARGET_LOCAL_NED_y", ftypes.FLOAT, nil)
f.SET_POSITION_TARGET_LOCAL_NED_z = ProtoField.new("z (float) [m]", "mavlink_proto.SET_POSITION_TARGET_LOCAL_NED_z", ftypes.FLOAT, nil)
f.SET_POSITION_TARGET_LOCAL_NED_vx = ProtoField.new("vx (float) [m/s]", "mavlink_proto.SET_POSITION_TARGET_LOCAL_NED_vx", ftypes.FLOAT, nil)
f.SET_POSITION_TARGET_LOCAL_NED_vy = ProtoField.new("vy (float) [m/s]", "mavlink_proto.SET_POSITION_TARGET_LOCAL_NED_vy", ftypes.FLOAT, nil)
f.SET_POSITION_TARGET_LOCAL_NED_vz = ProtoField.new("vz (float) [m/s]", "mavlink_proto.SET_POSITION_TARGET_LOCAL_NED_vz", ftypes.FLOAT, nil)
f.SET_POSITION_TARGET_LOCAL_NED_afx = ProtoField.new("afx (float) [m/s/s]", "mavlink_proto.SET_POSITION_TARGET_LOCAL_NED_afx", ftypes.FLOAT, nil)
f.SET_POSITION_TARGET_LOCAL_NED_afy = ProtoField.new("afy (float) [m/s/s]", "mavlink_proto.SET_POSITION_TARGET_LOCAL_NED_afy", ftypes.FLOAT, nil)
f.SET_POSITION_TARGET_LOCAL_NED_afz = ProtoField.new("afz (float) [m/s/s]", "mavlink_proto.SET_POSITION_TARGET_LOCAL_NED_afz", ftypes.FLOAT, nil)
f.SET_POSITION_TARGET_LOCAL_NED_yaw = ProtoField.new("yaw (float) [rad]", "mavlink_proto.SET_POSITION_TARGET_LOCAL_NED_yaw", ftypes.FLOAT, nil)
f.SET_POSITION_TARGET_LOCAL_NED_yaw_rate = ProtoField.new("yaw_rate (float) [rad/s]", "mavlink_proto.SET_POSITION_TARGET_LOCAL_NED_yaw_rate", ftypes.FLOAT, nil)

f.RADIO_STATUS_rssi = ProtoField.new("rssi (uint8_t)", "mavlink_proto.RADIO_STATUS_rssi", ftypes.UINT8, nil)
f.RADIO_STATUS_remrssi = ProtoField.new("remrssi (uint8_t)", "mavlink_proto.RADIO_STATUS_remrssi", ftypes.UINT8, nil)
f.RADIO_STATUS_txbuf = ProtoField.new("txbuf (uint8_t) [%]", "mavlink_proto.RADIO_STATUS_txbuf", ftypes.UINT8, nil)
f.RADIO_STATUS_noise = ProtoField.new("noise (uint8_t)", "mavlink_proto.RADIO_STATUS_noise", ftypes.UINT8, nil)
f.RADIO_STATUS_remnoise = ProtoField.new("remnoise (uint8_t)", "mavlink_proto.RADIO_STATUS_remnoise", ftypes.UINT8, nil)
f.RADIO_STATUS_rxerrors = ProtoField.new("rxerrors (uint16_t)", "mavlink_proto.RADIO_STATUS_rxerrors", ftypes.UINT16, nil)
f.RADIO_STATUS_fixed = ProtoField.new("fixed (uint16_t)", "mavlink_proto.RADIO_STATUS_fixed", ftypes.UINT16, nil)

f.FILE_TRANSFER_PROTOCOL_target_network = ProtoField.new("target_network (uint8_t)", "mavlink_proto.FILE_TRANSFER_PROTOCOL_target_network", ftypes.UINT8, nil)
f.FILE_TRANSFER_PROTOCOL_target_system = ProtoField.new("target_system (uint8_t)", "mavlink_proto.FILE_TRANSFER_PROTOCOL_target_system", ftypes.UINT8, nil)
f.FILE_TRANSFER_PROTOCOL_target_component = ProtoField.new("target_component (uint8_t)", "mavlink_proto.FILE_TRANSFER_PROTOCOL_target_component", ftypes.UINT8, nil)
for i = 0, 250 do
    f["FILE_TRANSFER_PROTOCOL_payload_"..i] = ProtoField.new("payload["..i.."] (uint8_t)", "mavlink_proto.FILE_TRANSFER_PROTOCOL_payload_"..i, ftypes.UINT8, nil)
end

f.MESSAGE_INTERVAL_message_id = ProtoField.new("message_id (uint16_t)", "mavlink_proto.MESSAGE_INTERVAL_message_id", ftypes.UINT16, nil)
f.MESSAGE_INTERVAL_interval_us = ProtoField.new("interval_us (int32_t) [us]", "mavlink_proto.MESSAGE_INTERVAL_interval_us", ftypes.INT32, nil)

f.EXTENDED_SYS_STATE_vtol_state = ProtoField.new("vtol_state (MAV_VTOL_STATE)", "mavlink_proto.EXTENDED_SYS_STATE_vtol_state", ftypes.UINT8, enumEntryName.MAV_VTOL_STATE)
f.EXTENDED_SYS_STATE_landed_state = ProtoField.new("landed_state (MAV_LANDED_STATE)", "mavlink_proto.EXTENDED_SYS_STATE_landed_state", ftypes.UINT8, enumEntryName.MAV_LANDED_STATE)

f.NAMED_VALUE_FLOAT_time_boot_ms = ProtoField.new("time_boot_ms (uint32_t) [ms]", "mavlink_proto.NAMED_VALUE_FLOAT_time_boot_ms", ftypes.UINT32, nil)
f.NAMED_VALUE_FLOAT_name = ProtoField.new("name (char)", "mavlink_proto.NAMED_VALUE_FLOAT_name", ftypes.STRING, nil)
f.NAMED_VALUE_FLOAT_value = ProtoField.new("value (float)", "mavlink_proto.NAMED_VALUE_FLOAT_value", ftypes.FLOAT, nil)

f.STATUSTEXT_severity = ProtoField.new("severity (MAV_SEVERITY)", "mavlink_proto.STATUSTEXT_severity", ftypes.UINT8, enumEntryName.MAV_SEVERITY)
f.STATUSTEXT_text = ProtoField.new("text (char)", "mavlink_proto.STATUSTEXT_text", ftypes.STRING, nil)
f.STATUSTEXT_id = ProtoField.new("id (uint16_t)", "mavlink_proto.STATUSTEXT_id", ftypes.UINT16, nil)
f.STATUSTEXT_chunk_seq = ProtoField.new("chunk_seq (uint8_t)", "mavlink_proto.STATUSTEXT_chunk_seq", ftypes.UINT8, nil)

f.GIMBAL_MANAGER_INFORMATION_time_boot_ms = ProtoField.new("time_boot_ms (uint32_t) [ms]", "mavlink_proto.GIMBAL_MANAGER_INFORMATION_time_boot_ms", ftypes.UINT32, nil)
f.GIMBAL_MANAGER_INFORMATION_cap_flags = ProtoField.new("cap_flags (GIMBAL_MANAGER_CAP_FLAGS)", "mavlink_proto.GIMBAL_MANAGER_INFORMATION_cap_flags", ftypes.UINT32, nil, base.HEX_DEC)
f.GIMBAL_MANAGER_INFORMATION_cap_flags_flagGIMBAL_MANAGER_CAP_FLAGS_HAS_RETRACT = ProtoField.bool("mavlink_proto.GIMBAL_MANAGER_INFORMATION_cap_flags.GIMBAL_MANAGER_CAP_FLAGS_HAS_RETRACT", "GIMBAL_MANAGER_CAP_FLAGS_HAS_RETRACT", 20, nil, 1)
f.GIMBAL_MANAGER_INFORMATION_cap_flags_flagGIMBAL_MANAGER_CAP_FLAGS_HAS_NEUTRAL = ProtoField.bool("mavlink_proto.GIMBAL_MANAGER_INFORMATION_cap_flags.GIMBAL_MANAGER_CAP_FLAGS_HAS_NEUTRAL", "GIMBAL_MANAGER_CAP_FLAGS_HAS_NEUTRAL", 20, nil, 2)
f.GIMBAL_MANAGER_INFORMATION_cap_flags_flagGIMBAL_MANAGER_CAP_FLAGS_HAS_ROLL_AXIS = ProtoField.bool("mavlink_proto.GIMBAL_MANAGER_INFORMATION_cap_flags.GIMBAL_MANAGER_CAP_FLAGS_HAS_ROLL_AXIS", "GIMBAL_MANAGER_CAP_FLAGS_HAS_ROLL_AXIS", 20, nil, 4)
f.GIMBAL_MANAGER_INFORMATION_cap_flags_flagGIMBAL_MANAGER_CAP_FLAGS_HAS_ROLL_FOLLOW = ProtoField.bool("mavlink_proto.GIMBAL_MANAGER_INFORMATION_cap_flags.GIMBAL_MANAGER_CAP_FLAGS_HAS_ROLL_FOLLOW", "GIMBAL_MANAGER_CAP_FLAGS_HAS_ROLL_FOLLOW", 20, nil, 8)
f.GIMBAL_MANAGER_INFORMATION_cap_flags_flagGIMBAL_MANAGER_CAP_FLAGS_HAS_ROLL_LOCK = ProtoField.bool("mavlink_proto.GIMBAL_MANAGER_INFORMATION_cap_flags.GIMBAL_MANAGER_CAP_FLAGS_HAS_ROLL_LOCK", "GIMBAL_MANAGER_CAP_FLAGS_HAS_ROLL_LOCK", 20, nil, 16)
f.GIMBAL_MANAGER_INFORMATION_cap_flags_flagGIMBAL_MANAGER_CAP_FLAGS_HAS_PITCH_AXIS = ProtoField.bool("mavlink_proto.GIMBAL_MANAGER_INFORMATION_cap_flags.GIMBAL_MANAGER_CAP_FLAGS_HAS_PITCH_AXIS", "GIMBAL_MANAGER_CAP_FLAGS_HAS_PITCH_AXIS", 20, nil, 32)
f.GIMBAL_MANAGER_INFORMATION_cap_flags_flagGIMBAL_MANAGER_CAP_FLAGS_HAS_PITCH_FOLLOW = ProtoField.bool("mavlink_proto.GIMBAL_MANAGER_INFORMATION_cap_flags.GIMBAL_MANAGER_CAP_FLAGS_HAS_PITCH_FOLLOW", "GIMBAL_MANAGER_CAP_FLAGS_HAS_PITCH_FOLLOW", 20, nil, 64)
f.GIMBAL_MANAGER_INFORMATION_cap_flags_flagGIMBAL_MANAGER_CAP_FLAGS_HAS_PITCH_LOCK = ProtoField.bool("mavlink_proto.GIMBAL_MANAGER_INFORMATION_cap_flags.GIMBAL_MANAGER_CAP_FLAGS_HAS_PITCH_LOCK", "GIMBAL_MANAGER_CAP_FLAGS_HAS_PITCH_LOCK", 20, nil, 128)
f.GIMBAL_MANAGER_INFORMATION_cap_flags_flagGIMBAL_MANAGER_CAP_FLAGS_HAS_YAW_AXIS = ProtoField.bool("mavlink_proto.GIMBAL_MANAGER_INFORMATION_cap_flags.GIMBAL_MANAGER_CAP_FLAGS_HAS_YAW_AXIS", "GIMBAL_MANAGER_CAP_FLAGS_HAS_YAW_AXIS", 20, nil, 256)
f.GIMBAL_MANAGER_INFORMATION_cap_flags_flagGIMBAL_MANAGER_CAP_FLAGS_HAS_YAW_FOLLOW = ProtoField.bool("mavlink_proto.GIMBAL_MANAGER_INFORMATION_cap_flags.GIMBAL_MANAGER_CAP_FLAGS_HAS_YAW_FOLLOW", "GIMBAL_MANAGER_CAP_FLAGS_HAS_YAW_FOLLOW", 20, nil, 512)
f.GIMBAL_MANAGER_INFORMATION_cap_flags_flagGIMBAL_MANAGER_CAP_FLAGS_HAS_YAW_LOCK = ProtoField.bool("mavlink_proto.GIMBAL_MANAGER_INFORMATION_cap_flags.GIMBAL_MANAGER_CAP_FLAGS_HAS_YAW_LOCK", "GIMBAL_MANAGER_CAP_FLAGS_HAS_YAW_LOCK", 20, nil, 1024)
f.GIMBAL_MANAGER_INFORMATION_cap_flags_flagGIMBAL_MANAGER_CAP_FLAGS_SUPPORTS_INFINITE_YAW = ProtoField.bool("mavlink_proto.GIMBAL_MANAGER_INFORMATION_cap_flags.GIMBAL_MANAGER_CAP_FLAGS_SUPPORTS_INFINITE_YAW", "GIMBAL_MANAGER_CAP_FLAGS_SUPPORTS_INFINITE_YAW", 20, nil, 2048)
f.GIMBAL_MANAGER_INFORMATION_cap_flags_flagGIMBAL_MANAGER_CAP_FLAGS_SUPPORTS_YAW_IN_EARTH_FRAME = ProtoField.bool("mavlink_proto.GIMBAL_MANAGER_INFORMATION_cap_flags.GIMBAL_MANAGER_CAP_FLAGS_SUPPORTS_YAW_IN_EARTH_FRAME", "GIMBAL_MANAGER_CAP_FLAGS_SUPPORTS_YAW_IN_EARTH_FRAME", 20, nil, 4096)
f.GIMBAL_MANAGER_INFORMATION_cap_flags_flagGIMBAL_MANAGER_CAP_FLAGS_HAS_RC_INPUTS = ProtoField.bool("mavlink_proto.GIMBAL_MANAGER_INFORMATION_cap_flags.GIMBAL_MANAGER_CAP_FLAGS_HAS_RC_INPUTS", "GIMBAL_MANAGER_CAP_FLAGS_HAS_RC_INPUTS", 20, nil, 8192)
f.GIMBAL_MANAGER_INFORMATION_cap_flags_flagGIMBAL_MANAGER_CAP_FLAGS_CAN_POINT_LOCATION_LOCAL = ProtoField.bool("mavlink_proto.GIMBAL_MANAGER_INFORMATION_cap_flags.GIMBAL_MANAGER_CAP_FLAGS_CAN_POINT_LOCATION_LOCAL", "GIMBAL_MANAGER_CAP_FLAGS_CAN_POINT_LOCATION_LOCAL", 20, nil, 65536)
f.GIMBAL_MANAGER_INFORMATION_cap_flags_flagGIMBAL_MANAGER_CAP_FLAGS_CAN_POINT_LOCATION_GLOBAL = ProtoField.bool("mavlink_proto.GIMBAL_MANAGER_INFORMATION_cap_flags.GIMBAL_MANAGER_CAP_FLAGS_CAN_POINT_LOCATION_GLOBAL", "GIMBAL_MANAGER_CAP_FLAGS_CAN_POINT_LOCATION_GLOBAL", 20, nil, 131072)
f.GIMBAL_MANAGER_INFORMATION_gimbal_device_id = ProtoField.new("gimbal_device_id (uint8_t)", "mavlink_proto.GIMBAL_MANAGER_INFORMATION_gimbal_device_id", ftypes.UINT8, nil)
f.GIMBAL_MANAGER_INFORMATION_roll_min = ProtoField.new("roll_min (float) [rad]", "mavlink_proto.GIMBAL_MANAGER_INFORMATION_roll_min", ftypes.FLOAT, nil)
f.GIMBAL_MANAGER_INFORMATION_roll_max = ProtoField.new("roll_max (float) [rad]", "mavlink_proto.GIMBAL_MANAGER_INFORMATION_roll_max", ftypes.FLOAT, nil)
f.GIMBAL_MANAGER_INFORMATION_pitch_min = ProtoField.new("pitch_min (float) [rad]", "mavlink_proto.GIMBAL_MANAGER_INFORMATION_pitch_min", ftypes.FLOAT, nil)
f.GIMBAL_MANAGER_INFORMATION_pitch_max = ProtoField.new("pitch_max (float) [rad]", "mavlink_proto.GIMBAL_MANAGER_INFORMATION_pitch_max", ftypes.FLOAT, nil)
f.GIMBAL_MANAGER_INFORMATION_yaw_min = ProtoField.new("yaw_min (float) [rad]", "mavlink_proto.GIMBAL_MANAGER_INFORMATION_yaw_min", ftypes.FLOAT, nil)
f.GIMBAL_MANAGER_INFORMATION_yaw_max = ProtoField.new("yaw_max (float) [rad]", "mavlink_proto.GIMBAL_MANAGER_INFORMATION_yaw_max", ftypes.FLOAT, nil)

f.GIMBAL_MANAGER_STATUS_time_boot_ms = ProtoField.new("time_boot_ms (uint32_t) [ms]", "mavlink_proto.GIMBAL_MANAGER_STATUS_time_boot_ms", ftypes.UINT32, nil)
f.GIMBAL_MANAGER_STATUS_flags = ProtoField.new("flags (GIMBAL_MANAGER_FLAGS)", "mavlink_proto.GIMBAL_MANAGER_STATUS_flags", ftypes.UINT32, nil, base.HEX_DEC)
f.GIMBAL_MANAGER_STATUS_flags_flagGIMBAL_MANAGER_FLAGS_RETRACT = ProtoField.bool("mavlink_proto.GIMBAL_MANAGER_STATUS_flags.GIMBAL_MANAGER_FLAGS_RETRACT", "GIMBAL_MANAGER_FLAGS_RETRACT", 12, nil, 1)
f.GIMBAL_MANAGER_STATUS_flags_flagGIMBAL_MANAGER_FLAGS_NEUTRAL = ProtoField.bool("mavlink_proto.GIMBAL_MANAGER_STATUS_flags.GIMBAL_MANAGER_FLAGS_NEUTRAL", "GIMBAL_MANAGER_FLAGS_NEUTRAL", 12, nil, 2)
f.GIMBAL_MANAGER_STATUS_flags_flagGIMBAL_MANAGER_FLAGS_ROLL_LOCK = ProtoField.bool("mavlink_proto.GIMBAL_MANAGER_STATUS_flags.GIMBAL_MANAGER_FLAGS_ROLL_LOCK", "GIMBAL_MANAGER_FLAGS_ROLL_LOCK", 12, nil, 4)
f.GIMBAL_MANAGER_STATUS_flags_flagGIMBAL_MANAGER_FLAGS_PITCH_LOCK = ProtoField.bool("mavlink_proto.GIMBAL_MANAGER_STATUS_flags.GIMBAL_MANAGER_FLAGS_PITCH_LOCK", "GIMBAL_MANAGER_FLAGS_PITCH_LOCK", 12, nil, 8)
f.GIMBAL_MANAGER_STATUS_flags_flagGIMBAL_MANAGER_FLAGS_YAW_LOCK = ProtoField.bool("mavlink_proto.GIMBAL_MANAGER_STATUS_flags.GIMBAL_MANAGER_FLAGS_YAW_LOCK", "GIMBAL_MANAGER_FLAGS_YAW_LOCK", 12, nil, 16)
f.GIMBAL_MANAGER_STATUS_flags_flagGIMBAL_MANAGER_FLAGS_YAW_IN_VEHICLE_FRAME = ProtoField.bool("mavlink_proto.GIMBAL_MANAGER_STATUS_flags.GIMBAL_MANAGER_FLAGS_YAW_IN_VEHICLE_FRAME", "GIMBAL_MANAGER_FLAGS_YAW_IN_VEHICLE_FRAME", 12, nil, 32)
f.GIMBAL_MANAGER_STATUS_flags_flagGIMBAL_MANAGER_FLAGS_YAW_IN_EARTH_FRAME = ProtoField.bool("mavlink_proto.GIMBAL_MANAGER_STATUS_flags.GIMBAL_MANAGER_FLAGS_YAW_IN_EARTH_FRAME", "GIMBAL_MANAGER_FLAGS_YAW_IN_EARTH_FRAME", 12, nil, 64)
f.GIMBAL_MANAGER_STATUS_flags_flagGIMBAL_MANAGER_FLAGS_ACCEPTS_YAW_IN_EARTH_FRAME = ProtoField.bool("mavlink_proto.GIMBAL_MANAGER_STATUS_flags.GIMBAL_MANAGER_FLAGS_ACCEPTS_YAW_IN_EARTH_FRAME", "GIMBAL_MANAGER_FLAGS_ACCEPTS_YAW_IN_EARTH_FRAME", 12, nil, 128)
f.GIMBAL_MANAGER_STATUS_flags_flagGIMBAL_MANAGER_FLAGS_RC_EXCLUSIVE = ProtoField.bool("mavlink_proto.GIMBAL_MANAGER_STATUS_flags.GIMBAL_MANAGER_FLAGS_RC_EXCLUSIVE", "GIMBAL_MANAGER_FLAGS_RC_EXCLUSIVE", 12, nil, 256)
f.GIMBAL_MANAGER_STATUS_flags_flagGIMBAL_MANAGER_FLAGS_RC_MIXED = ProtoField.bool("mavlink_proto.GIMBAL_MANAGER_STATUS_flags.GIMBAL_MANAGER_FLAGS_RC_MIXED", "GIMBAL_MANAGER_FLAGS_RC_MIXED", 12, nil, 512)
f.GIMBAL_MANAGER_STATUS_gimbal_device_id = ProtoField.new("gimbal_device_id (uint8_t)", "mavlink_proto.GIMBAL_MANAGER_STATUS_gimbal_device_id", ftypes.UINT8, nil)
f.GIMBAL_MANAGER_STATUS_primary_control_sysid = ProtoField.new("primary_control_sysid (uint8_t)", "mavlink_proto.GIMBAL_MANAGER_STATUS_primary_control_sysid", ftypes.UINT8, nil)
f.GIMBAL_MANAGER_STATUS_primary_control_compid = ProtoField.new("primary_control_compid (uint8_t)", "mavlink_proto.GIMBAL_MANAGER_STATUS_primary_control_compid", ftypes.UINT8, nil)
f.GIMBAL_MANAGER_STATUS_secondary_control_sysid = ProtoField.new("secondary_control_sysid (uint8_t)", "mavlink_proto.GIMBAL_MANAGER_STATUS_secondary_control_sysid", ftypes.UINT8, nil)
f.GIMBAL_MANAGER_STATUS_secondary_control_compid = ProtoField.new("secondary_control_compid (uint8_t)", "mavlink_proto.GIMBAL_MANAGER_STATUS_secondary_control_compid", ftypes.UINT8, nil)

f.GIMBAL_MANAGER_SET_ATTITUDE_target_system = ProtoField.new("target_system (uint8_t)", "mavlink_proto.GIMBAL_MANAGER_SET_ATTITUDE_target_system", ftypes.UINT8, nil)
f.GIMBAL_MANAGER_SET_ATTITUDE_target_component = ProtoField.new("target_component (uint8_t)", "mavlink_proto.GIMBAL_MANAGER_SET_ATTITUDE_target_component", ftypes.UINT8, nil)
f.GIMBAL_MANAGER_SET_ATTITUDE_flags = ProtoField.new("flags (GIMBAL_MANAGER_FLAGS)", "mavlink_proto.GIMBAL_MANAGER_SET_ATTITUDE_flags", ftypes.UINT32, nil, base.HEX_DEC)
f.GIMBAL_MANAGER_SET_ATTITUDE_flags_flagGIMBAL_MANAGER_FLAGS_RETRACT = ProtoField.bool("mavlink_proto.GIMBAL_MANAGER_SET_ATTITUDE_flags.GIMBAL_MANAGER_FLAGS_RETRACT", "GIMBAL_MANAGER_FLAGS_RETRACT", 12, nil, 1)
f.GIMBAL_MANAGER_SET_ATTITUDE_flags_flagGIMBAL_MANAGER_FLAGS_NEUTRAL = ProtoField.bool("mavlink_proto.GIMBAL_MANAGER_SET_ATTITUDE_flags.GIMBAL_MANAGER_FLAGS_NEUTRAL", "GIMBAL_MANAGER_FLAGS_NEUTRAL", 12, nil, 2)
f.GIMBAL_MANAGER_SET_ATTITUDE_flags_flagGIMBAL_MANAGER_FLAGS_ROLL_LOCK = ProtoField.bool("mavlink_proto.GIMBAL_MANAGER_SET_ATTITUDE_flags.GIMBAL_MANAGER_FLAGS_ROLL_LOCK", "GIMBAL_MANAGER_FLAGS_ROLL_LOCK", 12, nil, 4)
f.GIMBAL_MANAGER_SET_ATTITUDE_flags_flagGIMBAL_MANAGER_FLAGS_PITCH_LOCK = ProtoField.bool("mavlink_proto.GIMBAL_MANAGER_SET_ATTITUDE_flags.GIMBAL_MANAGER_FLAGS_PITCH_LOCK", "GIMBAL_MANAGER_FLAGS_PITCH_LOCK", 12, nil, 8)
f.GIMBAL_MANAGER_SET_ATTITUDE_flags_flagGIMBAL_MANAGER_FLAGS_YAW_LOCK = ProtoField.bool("mavlink_proto.GIMBAL_MANAGER_SET_ATTITUDE_flags.GIMBAL_MANAGER_FLAGS_YAW_LOCK", "GIMBAL_MANAGER_FLAGS_YAW_LOCK", 12, nil, 16)
f.GIMBAL_MANAGER_SET_ATTITUDE_flags_flagGIMBAL_MANAGER_FLAGS_YAW_IN_VEHICLE_FRAME = ProtoField.bool("mavlink_proto.GIMBAL_MANAGER_SET_ATTITUDE_flags.GIMBAL_MANAGER_FLAGS_YAW_IN_VEHICLE_FRAME", "GIMBAL_MANAGER_FLAGS_YAW_IN_VEHICLE_FRAME", 12, nil, 32)
f.GIMBAL_MANAGER_SET_ATTITUDE_flags_flagGIMBAL_MANAGER_FLAGS_YAW_IN_EARTH_FRAME = ProtoField.bool("mavlink_proto.GIMBAL_MANAGER_SET_ATTITUDE_flags.GIMBAL_MANAGER_FLAGS_YAW_IN_EARTH_FRAME", "GIMBAL_MANAGER_FLAGS_YAW_IN_EARTH_FRAME", 12, nil, 64)
f.GIMBAL_MANAGER_SET_ATTITUDE_flags_flagGIMBAL_MANAGER_FLAGS_ACCEPTS_YAW_IN_EARTH_FRAME = ProtoField.bool("mavlink_proto.GIMBAL_MANAGER_SET_ATTITUDE_flags.GIMBAL_MANAGER_FLAGS_ACCEPTS_YAW_IN_EARTH_FRAME", "GIMBAL_MANAGER_FLAGS_ACCEPTS_YAW_IN_EARTH_FRAME", 12, nil, 128)
f.GIMBAL_MANAGER_SET_ATTITUDE_flags_flagGIMBAL_MANAGER_FLAGS_RC_EXCLUSIVE = ProtoField.bool("mavlink_proto.GIMBAL_MANAGER_SET_ATTITUDE_flags.GIMBAL_MANAGER_FLAGS_RC_EXCLUSIVE", "GIMBAL_MANAGER_FLAGS_RC_EXCLUSIVE", 12, nil, 256)
f.GIMBAL_MANAGER_SET_ATTITUDE_flags_flagGIMBAL_MANAGER_FLAGS_RC_MIXED = ProtoField.bool("mavlink_proto.GIMBAL_MANAGER_SET_ATTITUDE_flags.GIMBAL_MANAGER_FLAGS_RC_MIXED", "GIMBAL_MANAGER_FLAGS_RC_MIXED", 12, nil, 512)
f.GIMBAL_MANAGER_SET_ATTITUDE_gimbal_device_id = ProtoField.new("gimbal_device_id (uint8_t)", "mavlink_proto.GIMBAL_MANAGER_SET_ATTITUDE_gimbal_device_id", ftypes.UINT8, nil)
for i = 0, 3 do
    f["GIMBAL_MANAGER_SET_ATTITUDE_q_"..i] = ProtoField.new("q["..i.."] (float)", "mavlink_proto.GIMBAL_MANAGER_SET_ATTITUDE_q_"..i, ftypes.FLOAT, nil)
end
f.GIMBAL_MANAGER_SET_ATTITUDE_angular_velocity_x = ProtoField.new("angular_velocity_x (float) [rad/s]", "mavlink_proto.GIMBAL_MANAGER_SET_ATTITUDE_angular_velocity_x", ftypes.FLOAT, nil)
f.GIMBAL_MANAGER_SET_ATTITUDE_angular_velocity_y = ProtoField.new("angular_velocity_y (float) [rad/s]", "mavlink_proto.GIMBAL_MANAGER_SET_ATTITUDE_angular_velocity_y", ftypes.FLOAT, nil)
f.GIMBAL_MANAGER_SET_ATTITUDE_angular_velocity_z = ProtoField.new("angular_velocity_z (float) [rad/s]", "mavlink_proto.GIMBAL_MANAGER_SET_ATTITUDE_angular_velocity_z", ftypes.FLOAT, nil)

f.GIMBAL_DEVICE_INFORMATION_time_boot_ms = ProtoField.new("time_boot_ms (uint32_t) [ms]", "mavlink_proto.GIMBAL_DEVICE_INFORMATION_time_boot_ms", ftypes.UINT32, nil)
f.GIMBAL_DEVICE_INFORMATION_vendor_name = ProtoField.new("vendor_name (char)", "mavlink_proto.GIMBAL_DEVICE_INFORMATION_vendor_name", ftypes.STRING, nil)
f.GIMBAL_DEVICE_INFORMATION_model_name = ProtoField.new("model_name (char)", "mavlink_proto.GIMBAL_DEVICE_INFORMATION_model_name", ftypes.STRING, nil)
f.GIMBAL_DEVICE_INFORMATION_custom_name = ProtoField.new("custom_name (char)", "mavlink_proto.GIMBAL_DEVICE_INFORMATION_custom_name", ftypes.STRING, nil)
f.GIMBAL_DEVICE_INFORMATION_firmware_version = ProtoField.new("firmware_version (uint32_t)", "mavlink_proto.GIMBAL_DEVICE_INFORMATION_firmware_version", ftypes.UINT32, nil)
f.GIMBAL_DEVICE_INFORMATION_hardware_version = ProtoField.new("hardware_version (uint32_t)", "mavlink_proto.GIMBAL_DEVICE_INFORMATION_hardware_version", ftypes.UINT32, nil)
f.GIMBAL_DEVICE_INFORMATION_uid = ProtoField.new("uid (uint64_t)", "mavlink_proto.GIMBAL_DEVICE_INFORMATION_uid", ftypes.UINT64, nil)
f.GIMBAL_DEVICE_INFORMATION_cap_flags = ProtoField.new("cap_flags (GIMBAL_DEVICE_CAP_FLAGS)", "mavlink_proto.GIMBAL_DEVICE_INFORMATION_cap_flags", ftypes.UINT16, nil, base.HEX_DEC)
f.GIMBAL_DEVICE_INFORMATION_cap_flags_flagGIMBAL_DEVICE_CAP_FLAGS_HAS_RETRACT = ProtoField.bool("mavlink_proto.GIMBAL_DEVICE_INFORMATION_cap_flags.GIMBAL_DEVICE_CAP_FLAGS_HAS_RETRACT", "GIMBAL_DEVICE_CAP_FLAGS_HAS_RETRACT", 20, nil, 1)
f.GIMBAL_DEVICE_INFORMATION_cap_flags_flagGIMBAL_DEVICE_CAP_FLAGS_HAS_NEUTRAL = ProtoField.bool("mavlink_proto.GIMBAL_DEVICE_INFORMATION_cap_flags.GIMBAL_DEVICE_CAP_FLAGS_HAS_NEUTRAL", "GIMBAL_DEVICE_CAP_FLAGS_HAS_NEUTRAL", 20, nil, 2)
f.GIMBAL_DEVICE_INFORMATION_cap_flags_flagGIMBAL_DEVICE_CAP_FLAGS_HAS_ROLL_AXIS = ProtoField.bool("mavlink_proto.GIMBAL_DEVICE_INFORMATION_cap_flags.GIMBAL_DEVICE_CAP_FLAGS_HAS_ROLL_AXIS", "GIMBAL_DEVICE_CAP_FLAGS_HAS_ROLL_AXIS", 20, nil, 4)
f.GIMBAL_DEVICE_INFORMATION_cap_flags_flagGIMBAL_DEVICE_CAP_FLAGS_HAS_ROLL_FOLLOW = ProtoField.bool("mavlink_proto.GIMBAL_DEVICE_INFORMATION_cap_flags.GIMBAL_DEVICE_CAP_FLAGS_HAS_ROLL_FOLLOW", "GIMBAL_DEVICE_CAP_FLAGS_HAS_ROLL_FOLLOW", 20, nil, 8)
f.GIMBAL_DEVICE_INFORMATION_cap_flags_flagGIMBAL_DEVICE_CAP_FLAGS_HAS_ROLL_LOCK = ProtoField.bool("mavlink_proto.GIMBAL_DEVICE_INFORMATION_cap_flags.GIMBAL_DEVICE_CAP_FLAGS_HAS_ROLL_LOCK", "GIMBAL_DEVICE_CAP_FLAGS_HAS_ROLL_LOCK", 20, nil, 16)
f.GIMBAL_DEVICE_INFORMATION_cap_flags_flagGIMBAL_DEVICE_CAP_FLAGS_HAS_PITCH_AXIS = ProtoField.bool("mavlink_proto.GIMBAL_DEVICE_INFORMATION_cap_flags.GIMBAL_DEVICE_CAP_FLAGS_HAS_PITCH_AXIS", "GIMBAL_DEVICE_CAP_FLAGS_HAS_PITCH_AXIS", 20, nil, 32)
f.GIMBAL_DEVICE_INFORMATION_cap_flags_flagGIMBAL_DEVICE_CAP_FLAGS_HAS_PITCH_FOLLOW = ProtoField.bool("mavlink_proto.GIMBAL_DEVICE_INFORMATION_cap_flags.GIMBAL_DEVICE_CAP_FLAGS_HAS_PITCH_FOLLOW", "GIMBAL_DEVICE_CAP_FLAGS_HAS_PITCH_FOLLOW", 20, nil, 64)
f.GIMBAL_DEVICE_INFORMATION_cap_flags_flagGIMBAL_DEVICE_CAP_FLAGS_HAS_PITCH_LOCK = ProtoField.bool("mavlink_proto.GIMBAL_DEVICE_INFORMATION_cap_flags.GIMBAL_DEVICE_CAP_FLAGS_HAS_PITCH_LOCK", "GIMBAL_DEVICE_CAP_FLAGS_HAS_PITCH_LOCK", 20, nil, 128)
f.GIMBAL_DEVICE_INFORMATION_cap_flags_flagGIMBAL_DEVICE_CAP_FLAGS_HAS_YAW_AXIS = ProtoField.bool("mavlink_proto.GIMBAL_DEVICE_INFORMATION_cap_flags.GIMBAL_DEVICE_CAP_FLAGS_HAS_YAW_AXIS", "GIMBAL_DEVICE_CAP_FLAGS_HAS_YAW_AXIS", 20, nil, 256)
f.GIMBAL_DEVICE_INFORMATION_cap_flags_flagGIMBAL_DEVICE_CAP_FLAGS_HAS_YAW_FOLLOW = ProtoField.bool("mavlink_proto.GIMBAL_DEVICE_INFORMATION_cap_flags.GIMBAL_DEVICE_CAP_FLAGS_HAS_YAW_FOLLOW", "GIMBAL_DEVICE_CAP_FLAGS_HAS_YAW_FOLLOW", 20, nil, 512)
f.GIMBAL_DEVICE_INFORMATION_cap_flags_flagGIMBAL_DEVICE_CAP_FLAGS_HAS_YAW_LOCK = ProtoField.bool("mavlink_proto.GIMBAL_DEVICE_INFORMATION_cap_flags.GIMBAL_DEVICE_CAP_FLAGS_HAS_YAW_LOCK", "GIMBAL_DEVICE_CAP_FLAGS_HAS_YAW_LOCK", 20, nil, 1024)
f.GIMBAL_DEVICE_INFORMATION_cap_flags_flagGIMBAL_DEVICE_CAP_FLAGS_SUPPORTS_INFINITE_YAW = ProtoField.bool("mavlink_proto.GIMBAL_DEVICE_INFORMATION_cap_flags.GIMBAL_DEVICE_CAP_FLAGS_SUPPORTS_INFINITE_YAW", "GIMBAL_DEVICE_CAP_FLAGS_SUPPORTS_INFINITE_YAW", 20, nil, 2048)
f.GIMBAL_DEVICE_INFORMATION_cap_flags_flagGIMBAL_DEVICE_CAP_FLAGS_SUPPORTS_YAW_IN_EARTH_FRAME = ProtoField.bool("mavlink_proto.GIMBAL_DEVICE_INFORMATION_cap_flags.GIMBAL_DEVICE_CAP_FLAGS_SUPPORTS_YAW_IN_EARTH_FRAME", "GIMBAL_DEVICE_CAP_FLAGS_SUPPORTS_YAW_IN_EARTH_FRAME", 20, nil, 4096)
f.GIMBAL_DEVICE_INFORMATION_cap_flags_flagGIMBAL_DEVICE_CAP_FLAGS_HAS_RC_INPUTS = ProtoField.bool("mavlink_proto.GIMBAL_DEVICE_INFORMATION_cap_flags.GIMBAL_DEVICE_CAP_FLAGS_HAS_RC_INPUTS", "GIMBAL_DEVICE_CAP_FLAGS_HAS_RC_INPUTS", 20, nil, 8192)
f.GIMBAL_DEVICE_INFORMATION_cap_flags_flagGIMBAL_DEVICE_CAP_FLAGS_CAN_POINT_LOCATION_LOCAL = ProtoField.bool("mavlink_proto.GIMBAL_DEVICE_INFORMATION_cap_flags.GIMBAL_DEVICE_CAP_FLAGS_CAN_POINT_LOCATION_LOCAL", "GIMBAL_DEVICE_CAP_FLAGS_CAN_POINT_LOCATION_LOCAL", 20, nil, 65536)
f.GIMBAL_DEVICE_INFORMATION_cap_flags_flagGIMBAL_DEVICE_CAP_FLAGS_CAN_POINT_LOCATION_GLOBAL = ProtoField.bool("mavlink_proto.GIMBAL_DEVICE_INFORMATION_cap_flags.GIMBAL_DEVICE_CAP_FLAGS_CAN_POINT_LOCATION_GLOBAL", "GIMBAL_DEVICE_CAP_FLAGS_CAN_POINT_LOCATION_GLOBAL", 20, nil, 131072)
f.GIMBAL_DEVICE_INFORMATION_custom_cap_flags = ProtoField.new("custom_cap_flags (uint16_t)", "mavlink_proto.GIMBAL_DEVICE_INFORMATION_custom_cap_flags", ftypes.UINT16, nil)
f.GIMBAL_DEVICE_INFORMATION_roll_min = ProtoField.new("roll_min (float) [rad]", "mavlink_proto.GIMBAL_DEVICE_INFORMATION_roll_min", ftypes.FLOAT, nil)
f.GIMBAL_DEVICE_INFORMATION_roll_max = ProtoField.new("roll_max (float) [rad]", "mavlink_proto.GIMBAL_DEVICE_INFORMATION_roll_max", ftypes.FLOAT, nil)
f.GIMBAL_DEVICE_INFORMATION_pitch_min = ProtoField.new("pitch_min (float) [rad]", "mavlink_proto.GIMBAL_DEVICE_INFORMATION_pitch_min", ftypes.FLOAT, nil)
f.GIMBAL_DEVICE_INFORMATION_pitch_max = ProtoField.new("pitch_max (float) [rad]", "mavlink_proto.GIMBAL_DEVICE_INFORMATION_pitch_max", ftypes.FLOAT, nil)
f.GIMBAL_DEVICE_INFORMATION_yaw_min = ProtoField.new("yaw_min (float) [rad]", "mavlink_proto.GIMBAL_DEVICE_INFORMATION_yaw_min", ftypes.FLOAT, nil)
f.GIMBAL_DEVICE_INFORMATION_yaw_max = ProtoField.new("yaw_max (float) [rad]", "mavlink_proto.GIMBAL_DEVICE_INFORMATION_yaw_max", ftypes.FLOAT, nil)
f.GIMBAL_DEVICE_INFORMATION_gimbal_device_id = ProtoField.new("gimbal_device_id (uint8_t)", "mavlink_proto.GIMBAL_DEVICE_INFORMATION_gimbal_device_id", ftypes.UINT8, nil)
f.GIMBAL_DEVICE_INFORMATION_cap_flags2 = ProtoField.new("cap_flags2 (GIMBAL_DEVICE_CAP_FLAGS)", "mavlink_proto.GIMBAL_DEVICE_INFORMATION_cap_flags2", ftypes.UINT32, nil, base.HEX_DEC)
f.GIMBAL_DEVICE_INFORMATION_cap_flags2_flagGIMBAL_DEVICE_CAP_FLAGS_HAS_RETRACT = ProtoField.bool("mavlink_proto.GIMBAL_DEVICE_INFORMATION_cap_flags2.GIMBAL_DEVICE_CAP_FLAGS_HAS_RETRACT", "GIMBAL_DEVICE_CAP_FLAGS_HAS_RETRACT", 20, nil, 1)
f.GIMBAL_DEVICE_INFORMATION_cap_flags2_flagGIMBAL_DEVICE_CAP_FLAGS_HAS_NEUTRAL = ProtoField.bool("mavlink_proto.GIMBAL_DEVICE_INFORMATION_cap_flags2.GIMBAL_DEVICE_CAP_FLAGS_HAS_NEUTRAL", "GIMBAL_DEVICE_CAP_FLAGS_HAS_NEUTRAL", 20, nil, 2)
f.GIMBAL_DEVICE_INFORMATION_cap_flags2_flagGIMBAL_DEVICE_CAP_FLAGS_HAS_ROLL_AXIS = ProtoField.bool("mavlink_proto.GIMBAL_DEVICE_INFORMATION_cap_flags2.GIMBAL_DEVICE_CAP_FLAGS_HAS_ROLL_AXIS", "GIMBAL_DEVICE_CAP_FLAGS_HAS_ROLL_AXIS", 20, nil, 4)
f.GIMBAL_DEVICE_INFORMATION_cap_flags2_flagGIMBAL_DEVICE_CAP_FLAGS_HAS_ROLL_FOLLOW = ProtoField.bool("mavlink_proto.GIMBAL_DEVICE_INFORMATION_cap_flags2.GIMBAL_DEVICE_CAP_FLAGS_HAS_ROLL_FOLLOW", "GIMBAL_DEVICE_CAP_FLAGS_HAS_ROLL_FOLLOW", 20, nil, 8)
f.GIMBAL_DEVICE_INFORMATION_cap_flags2_flagGIMBAL_DEVICE_CAP_FLAGS_HAS_ROLL_LOCK = ProtoField.bool("mavlink_proto.GIMBAL_DEVICE_INFORMATION_cap_flags2.GIMBAL_DEVICE_CAP_FLAGS_HAS_ROLL_LOCK", "GIMBAL_DEVICE_CAP_FLAGS_HAS_ROLL_LOCK", 20, nil, 16)
f.GIMBAL_DEVICE_INFORMATION_cap_flags2_flagGIMBAL_DEVICE_CAP_FLAGS_HAS_PITCH_AXIS = ProtoField.bool("mavlink_proto.GIMBAL_DEVICE_INFORMATION_cap_flags2.GIMBAL_DEVICE_CAP_FLAGS_HAS_PITCH_AXIS", "GIMBAL_DEVICE_CAP_FLAGS_HAS_PITCH_AXIS", 20, nil, 32)
f.GIMBAL_DEVICE_INFORMATION_cap_flags2_flagGIMBAL_DEVICE_CAP_FLAGS_HAS_PITCH_FOLLOW = ProtoField.bool("mavlink_proto.GIMBAL_DEVICE_INFORMATION_cap_flags2.GIMBAL_DEVICE_CAP_FLAGS_HAS_PITCH_FOLLOW", "GIMBAL_DEVICE_CAP_FLAGS_HAS_PITCH_FOLLOW", 20, nil, 64)
f.GIMBAL_DEVICE_INFORMATION_cap_flags2_flagGIMBAL_DEVICE_CAP_FLAGS_HAS_PITCH_LOCK = ProtoField.bool("mavlink_proto.GIMBAL_DEVICE_INFORMATION_cap_flags2.GIMBAL_DEVICE_CAP_FLAGS_HAS_PITCH_LOCK", "GIMBAL_DEVICE_CAP_FLAGS_HAS_PITCH_LOCK", 20, nil, 128)
f.GIMBAL_DEVICE_INFORMATION_cap_flags2_flagGIMBAL_DEVICE_CAP_FLAGS_HAS_YAW_AXIS = ProtoField.bool("mavlink_proto.GIMBAL_DEVICE_INFORMATION_cap_flags2.GIMBAL_DEVICE_CAP_FLAGS_HAS_YAW_AXIS", "GIMBAL_DEVICE_CAP_FLAGS_HAS_YAW_AXIS", 20, nil, 256)
f.GIMBAL_DEVICE_INFORMATION_cap_flags2_flagGIMBAL_DEVICE_CAP_FLAGS_HAS_YAW_FOLLOW = ProtoField.bool("mavlink_proto.GIMBAL_DEVICE_INFORMATION_cap_flags2.GIMBAL_DEVICE_CAP_FLAGS_HAS_YAW_FOLLOW", "GIMBAL_DEVICE_CAP_FLAGS_HAS_YAW_FOLLOW", 20, nil, 512)
f.GIMBAL_DEVICE_INFORMATION_cap_flags2_flagGIMBAL_DEVICE_CAP_FLAGS_HAS_YAW_LOCK = ProtoField.bool("mavlink_proto.GIMBAL_DEVICE_INFORMATION_cap_flags2.GIMBAL_DEVICE_CAP_FLAGS_HAS_YAW_LOCK", "GIMBAL_DEVICE_CAP_FLAGS_HAS_YAW_LOCK", 20, nil, 1024)
f.GIMBAL_DEVICE_INFORMATION_cap_flags2_flagGIMBAL_DEVICE_CAP_FLAGS_SUPPORTS_INFINITE_YAW = ProtoField.bool("mavlink_proto.GIMBAL_DEVICE_INFORMATION_cap_flags2.GIMBAL_DEVICE_CAP_FLAGS_SUPPORTS_INFINITE_YAW", "GIMBAL_DEVICE_CAP_FLAGS_SUPPORTS_INFINITE_YAW", 20, nil, 2048)
f.GIMBAL_DEVICE_INFORMATION_cap_flags2_flagGIMBAL_DEVICE_CAP_FLAGS_SUPPORTS_YAW_IN_EARTH_FRAME = ProtoField.bool("mavlink_proto.GIMBAL_DEVICE_INFORMATION_cap_flags2.GIMBAL_DEVICE_CAP_FLAGS_SUPPORTS_YAW_IN_EARTH_FRAME", "GIMBAL_DEVICE_CAP_FLAGS_SUPPORTS_YAW_IN_EARTH_FRAME", 20, nil, 4096)
f.GIMBAL_DEVICE_INFORMATION_cap_flags2_flagGIMBAL_DEVICE_CAP_FLAGS_HAS_RC_INPUTS = ProtoField.bool("mavlink_proto.GIMBAL_DEVICE_INFORMATION_cap_flags2.GIMBAL_DEVICE_CAP_FLAGS_HAS_RC_INPUTS", "GIMBAL_DEVICE_CAP_FLAGS_HAS_RC_INPUTS", 20, nil, 8192)
f.GIMBAL_DEVICE_INFORMATION_cap_flags2_flagGIMBAL_DEVICE_CAP_FLAGS_CAN_POINT_LOCATION_LOCAL = ProtoField.bool("mavlink_proto.GIMBAL_DEVICE_INFORMATION_cap_flags2.GIMBAL_DEVICE_CAP_FLAGS_CAN_POINT_LOCATION_LOCAL", "GIMBAL_DEVICE_CAP_FLAGS_CAN_POINT_LOCATION_LOCAL", 20, nil, 65536)
f.GIMBAL_DEVICE_INFORMATION_cap_flags2_flagGIMBAL_DEVICE_CAP_FLAGS_CAN_POINT_LOCATION_GLOBAL = ProtoField.bool("mavlink_proto.GIMBAL_DEVICE_INFORMATION_cap_flags2.GIMBAL_DEVICE_CAP_FLAGS_CAN_POINT_LOCATION_GLOBAL", "GIMBAL_DEVICE_CAP_FLAGS_CAN_POINT_LOCATION_GLOBAL", 20, nil, 131072)

f.GIMBAL_DEVICE_SET_ATTITUDE_target_system = ProtoField.new("target_system (uint8_t)", "mavlink_proto.GIMBAL_DEVICE_SET_ATTITUDE_target_system", ftypes.UINT8, nil)
f.GIMBAL_DEVICE_SET_ATTITUDE_target_component = ProtoField.new("target_component (uint8_t)", "mavlink_proto.GIMBAL_DEVICE_SET_ATTITUDE_target_component", ftypes.UINT8, nil)
f.GIMBAL_DEVICE_SET_ATTITUDE_flags = ProtoField.new("flags (GIMBAL_DEVICE_FLAGS)", "mavlink_proto.GIMBAL_DEVICE_SET_ATTITUDE_flags", ftypes.UINT16, nil, base.HEX_DEC)
f.GIMBAL_DEVICE_SET_ATTITUDE_flags_flagGIMBAL_DEVICE_FLAGS_RETRACT = ProtoField.bool("mavlink_proto.GIMBAL_DEVICE_SET_ATTITUDE_flags.GIMBAL_DEVICE_FLAGS_RETRACT", "GIMBAL_DEVICE_FLAGS_RETRACT", 12, nil, 1)
f.GIMBAL_DEVICE_SET_ATTITUDE_flags_flagGIMBAL_DEVICE_FLAGS_NEUTRAL = ProtoField.bool("mavlink_proto.GIMBAL_DEVICE_SET_ATTITUDE_flags.GIMBAL_DEVICE_FLAGS_NEUTRAL", "GIMBAL_DEVICE_FLAGS_NEUTRAL", 12, nil, 2)
f.GIMBAL_DEVICE_SET_ATTITUDE_flags_flagGIMBAL_DEVICE_FLAGS_ROLL_LOCK = ProtoField.bool("mavlink_proto.GIMBAL_DEVICE_SET_ATTITUDE_flags.GIMBAL_DEVICE_FLAGS_ROLL_LOCK", "GIMBAL_DEVICE_FLAGS_ROLL_LOCK", 12, nil, 4)
f.GIMBAL_DEVICE_SET_ATTITUDE_flags_flagGIMBAL_DEVICE_FLAGS_PITCH_LOCK = ProtoField.bool("mavlink_proto.GIMBAL_DEVICE_SET_ATTITUDE_flags.GIMBAL_DEVICE_FLAGS_PITCH_LOCK", "GIMBAL_DEVICE_FLAGS_PITCH_LOCK", 12, nil, 8)
f.GIMBAL_DEVICE_SET_ATTITUDE_flags_flagGIMBAL_DEVICE_FLAGS_YAW_LOCK = ProtoField.bool("mavlink_proto.GIMBAL_DEVICE_SET_ATTITUDE_flags.GIMBAL_DEVICE_FLAGS_YAW_LOCK", "GIMBAL_DEVICE_FLAGS_YAW_LOCK", 12, nil, 16)
f.GIMBAL_DEVICE_SET_ATTITUDE_flags_flagGIMBAL_DEVICE_FLAGS_YAW_IN_VEHICLE_FRAME = ProtoField.bool("mavlink_proto.GIMBAL_DEVICE_SET_ATTITUDE_flags.GIMBAL_DEVICE_FLAGS_YAW_IN_VEHICLE_FRAME", "GIMBAL_DEVICE_FLAGS_YAW_IN_VEHICLE_FRAME", 12, nil, 32)
f.GIMBAL_DEVICE_SET_ATTITUDE_flags_flagGIMBAL_DEVICE_FLAGS_YAW_IN_EARTH_FRAME = ProtoField.bool("mavlink_proto.GIMBAL_DEVICE_SET_ATTITUDE_flags.GIMBAL_DEVICE_FLAGS_YAW_IN_EARTH_FRAME", "GIMBAL_DEVICE_FLAGS_YAW_IN_EARTH_FRAME", 12, nil, 64)
f.GIMBAL_DEVICE_SET_ATTITUDE_flags_flagGIMBAL_DEVICE_FLAGS_ACCEPTS_YAW_IN_EARTH_FRAME = ProtoField.bool("mavlink_proto.GIMBAL_DEVICE_SET_ATTITUDE_flags.GIMBAL_DEVICE_FLAGS_ACCEPTS_YAW_IN_EARTH_FRAME", "GIMBAL_DEVICE_FLAGS_ACCEPTS_YAW_IN_EARTH_FRAME", 12, nil, 128)
f.GIMBAL_DEVICE_SET_ATTITUDE_flags_flagGIMBAL_DEVICE_FLAGS_RC_EXCLUSIVE = ProtoField.bool("mavlink_proto.GIMBAL_DEVICE_SET_ATTITUDE_flags.GIMBAL_DEVICE_FLAGS_RC_EXCLUSIVE", "GIMBAL_DEVICE_FLAGS_RC_EXCLUSIVE", 12, nil, 256)
f.GIMBAL_DEVICE_SET_ATTITUDE_flags_flagGIMBAL_DEVICE_FLAGS_RC_MIXED = ProtoField.bool("mavlink_proto.GIMBAL_DEVICE_SET_ATTITUDE_flags.GIMBAL_DEVICE_FLAGS_RC_MIXED", "GIMBAL_DEVICE_FLAGS_RC_MIXED", 12, nil, 512)
for i = 0, 3 do
    f["GIMBAL_DEVICE_SET_ATTITUDE_q_"..i] = ProtoField.new("q["..i.."] (float)", "mavlink_proto.GIMBAL_DEVICE_SET_ATTITUDE_q_"..i, ftypes.FLOAT, nil)
end
f.GIMBAL_DEVICE_SET_ATTITUDE_angular_velocity_x = ProtoField.new("angular_velocity_x (float) [rad/s]", "mavlink_proto.GIMBAL_DEVICE_SET_ATTITUDE_angular_velocity_x", ftypes.FLOAT, nil)
f.GIMBAL_DEVICE_SET_ATTITUDE_angular_velocity_y = ProtoField.new("angular_velocity_y (float) [rad/s]", "mavlink_proto.GIMBAL_DEVICE_SET_ATTITUDE_angular_velocity_y", ftypes.FLOAT, nil)
f.GIMBAL_DEVICE_SET_ATTITUDE_angular_velocity_z = ProtoField.new("angular_velocity_z (float) [rad/s]", "mavlink_proto.GIMBAL_DEVICE_SET_ATTITUDE_angular_velocity_z", ftypes.FLOAT, nil)

f.GIMBAL_DEVICE_ATTITUDE_STATUS_target_system = ProtoField.new("target_system (uint8_t)", "mavlink_proto.GIMBAL_DEVICE_ATTITUDE_STATUS_target_system", ftypes.UINT8, nil)
f.GIMBAL_DEVICE_ATTITUDE_STATUS_target_component = ProtoField.new("target_component (uint8_t)", "mavlink_proto.GIMBAL_DEVICE_ATTITUDE_STATUS_target_component", ftypes.UINT8, nil)
f.GIMBAL_DEVICE_ATTITUDE_STATUS_time_boot_ms = ProtoField.new("time_boot_ms (uint32_t) [ms]", "mavlink_proto.GIMBAL_DEVICE_ATTITUDE_STATUS_time_boot_ms", ftypes.UINT32, nil)
f.GIMBAL_DEVICE_ATTITUDE_STATUS_flags = ProtoField.new("flags (GIMBAL_DEVICE_FLAGS)", "mavlink_proto.GIMBAL_DEVICE_ATTITUDE_STATUS_flags", ftypes.UINT16, nil, base.HEX_DEC)
f.GIMBAL_DEVICE_ATTITUDE_STATUS_flags_flagGIMBAL_DEVICE_FLAGS_RETRACT = ProtoField.bool("mavlink_proto.GIMBAL_DEVICE_ATTITUDE_STATUS_flags.GIMBAL_DEVICE_FLAGS_RETRACT", "GIMBAL_DEVICE_FLAGS_RETRACT", 12, nil, 1)
f.GIMBAL_DEVICE_ATTITUDE_STATUS_flags_flagGIMBAL_DEVICE_FLAGS_NEUTRAL = ProtoField.bool("mavlink_proto.GIMBAL_DEVICE_ATTITUDE_STATUS_flags.GIMBAL_DEVICE_FLAGS_NEUTRAL", "GIMBAL_DEVICE_FLAGS_NEUTRAL", 12, nil, 2)
f.GIMBAL_DEVICE_ATTITUDE_STATUS_flags_flagGIMBAL_DEVICE_FLAGS_ROLL_LOCK = ProtoField.bool("mavlink_proto.GIMBAL_DEVICE_ATTITUDE_STATUS_flags.GIMBAL_DEVICE_FLAGS_ROLL_LOCK", "GIMBAL_DEVICE_FLAGS_ROLL_LOCK", 12, nil, 4)
f.GIMBAL_DEVICE_ATTITUDE_STATUS_flags_flagGIMBAL_DEVICE_FLAGS_PITCH_LOCK = ProtoField.bool("mavlink_proto.GIMBAL_DEVICE_ATTITUDE_STATUS_flags.GIMBAL_DEVICE_FLAGS_PITCH_LOCK", "GIMBAL_DEVICE_FLAGS_PITCH_LOCK", 12, nil, 8)
f.GIMBAL_DEVICE_ATTITUDE_STATUS_flags_flagGIMBAL_DEVICE_FLAGS_YAW_LOCK = ProtoField.bool("mavlink_proto.GIMBAL_DEVICE_ATTITUDE_STATUS_flags.GIMBAL_DEVICE_FLAGS_YAW_LOCK", "GIMBAL_DEVICE_FLAGS_YAW_LOCK", 12, nil, 16)
f.GIMBAL_DEVICE_ATTITUDE_STATUS_flags_flagGIMBAL_DEVICE_FLAGS_YAW_IN_VEHICLE_FRAME = ProtoField.bool("mavlink_proto.GIMBAL_DEVICE_ATTITUDE_STATUS_flags.GIMBAL_DEVICE_FLAGS_YAW_IN_VEHICLE_FRAME", "GIMBAL_DEVICE_FLAGS_YAW_IN_VEHICLE_FRAME", 12, nil, 32)
f.GIMBAL_DEVICE_ATTITUDE_STATUS_flags_flagGIMBAL_DEVICE_FLAGS_YAW_IN_EARTH_FRAME = ProtoField.bool("mavlink_proto.GIMBAL_DEVICE_ATTITUDE_STATUS_flags.GIMBAL_DEVICE_FLAGS_YAW_IN_EARTH_FRAME", "GIMBAL_DEVICE_FLAGS_YAW_IN_EARTH_FRAME", 12, nil, 64)
f.GIMBAL_DEVICE_ATTITUDE_STATUS_flags_flagGIMBAL_DEVICE_FLAGS_ACCEPTS_YAW_IN_EARTH_FRAME = ProtoField.bool("mavlink_proto.GIMBAL_DEVICE_ATTITUDE_STATUS_flags.GIMBAL_DEVICE_FLAGS_ACCEPTS_YAW_IN_EARTH_FRAME", "GIMBAL_DEVICE_FLAGS_ACCEPTS_YAW_IN_EARTH_FRAME", 12, nil, 128)
f.GIMBAL_DEVICE_ATTITUDE_STATUS_flags_flagGIMBAL_DEVICE_FLAGS_RC_EXCLUSIVE = ProtoField.bool("mavlink_proto.GIMBAL_DEVICE_ATTITUDE_STATUS_flags.GIMBAL_DEVICE_FLAGS_RC_EXCLUSIVE", "GIMBAL_DEVICE_FLAGS_RC_EXCLUSIVE", 12, nil, 256)
f.GIMBAL_DEVICE_ATTITUDE_STATUS_flags_flagGIMBAL_DEVICE_FLAGS_RC_MIXED = ProtoField.bool("mavlink_proto.GIMBAL_DEVICE_ATTITUDE_STATUS_flags.GIMBAL_DEVICE_FLAGS_RC_MIXED", "GIMBAL_DEVICE_FLAGS_RC_MIXED", 12, nil, 512)
for i = 0, 3 do
    f["GIMBAL_DEVICE_ATTITUDE_STATUS_q_"..i] = ProtoField.new("q["..i.."] (float)", "mavlink_proto.GIMBAL_DEVICE_ATTITUDE_STATUS_q_"..i, ftypes.FLOAT, nil)
end
f.GIMBAL_DEVICE_ATTITUDE_STATUS_angular_velocity_x = ProtoField.new("angular_velocity_x (float) [rad/s]", "mavlink_proto.GIMBAL_DEVICE_ATTITUDE_STATUS_angular_velocity_x", ftypes.FLOAT, nil)
f.GIMBAL_DEVICE_ATTITUDE_STATUS_angular_velocity_y = ProtoField.new("angular_velocity_y (float) [rad/s]", "mavlink_proto.GIMBAL_DEVICE_ATTITUDE_STATUS_angular_velocity_y", ftypes.FLOAT, nil)
f.GIMBAL_DEVICE_ATTITUDE_STATUS_angular_velocity_z = ProtoField.new("angular_velocity_z (float) [rad/s]", "mavlink_proto.GIMBAL_DEVICE_ATTITUDE_STATUS_angular_velocity_z", ftypes.FLOAT, nil)
f.GIMBAL_DEVICE_ATTITUDE_STATUS_failure_flags = ProtoField.new("failure_flags (GIMBAL_DEVICE_ERROR_FLAGS)", "mavlink_proto.GIMBAL_DEVICE_ATTITUDE_STATUS_failure_flags", ftypes.UINT32, nil, base.HEX_DEC)
f.GIMBAL_DEVICE_ATTITUDE_STATUS_failure_flags_flagGIMBAL_DEVICE_ERROR_FLAGS_AT_ROLL_LIMIT = ProtoField.bool("mavlink_proto.GIMBAL_DEVICE_ATTITUDE_STATUS_failure_flags.GIMBAL_DEVICE_ERROR_FLAGS_AT_ROLL_LIMIT", "GIMBAL_DEVICE_ERROR_FLAGS_AT_ROLL_LIMIT", 12, nil, 1)
f.GIMBAL_DEVICE_ATTITUDE_STATUS_failure_flags_flagGIMBAL_DEVICE_ERROR_FLAGS_AT_PITCH_LIMIT = ProtoField.bool("mavlink_proto.GIMBAL_DEVICE_ATTITUDE_STATUS_failure_flags.GIMBAL_DEVICE_ERROR_FLAGS_AT_PITCH_LIMIT", "GIMBAL_DEVICE_ERROR_FLAGS_AT_PITCH_LIMIT", 12, nil, 2)
f.GIMBAL_DEVICE_ATTITUDE_STATUS_failure_flags_flagGIMBAL_DEVICE_ERROR_FLAGS_AT_YAW_LIMIT = ProtoField.bool("mavlink_proto.GIMBAL_DEVICE_ATTITUDE_STATUS_failure_flags.GIMBAL_DEVICE_ERROR_FLAGS_AT_YAW_LIMIT", "GIMBAL_DEVICE_ERROR_FLAGS_AT_YAW_LIMIT", 12, nil, 4)
f.GIMBAL_DEVICE_ATTITUDE_STATUS_failure_flags_flagGIMBAL_DEVICE_ERROR_FLAGS_ENCODER_ERROR = ProtoField.bool("mavlink_proto.GIMBAL_DEVICE_ATTITUDE_STATUS_failure_flags.GIMBAL_DEVICE_ERROR_FLAGS_ENCODER_ERROR", "GIMBAL_DEVICE_ERROR_FLAGS_ENCODER_ERROR", 12, nil, 8)
f.GIMBAL_DEVICE_ATTITUDE_STATUS_failure_flags_flagGIMBAL_DEVICE_ERROR_FLAGS_POWER_ERROR = ProtoField.bool("mavlink_proto.GIMBAL_DEVICE_ATTITUDE_STATUS_failure_flags.GIMBAL_DEVICE_ERROR_FLAGS_POWER_ERROR", "GIMBAL_DEVICE_ERROR_FLAGS_POWER_ERROR", 12, nil, 16)
f.GIMBAL_DEVICE_ATTITUDE_STATUS_failure_flags_flagGIMBAL_DEVICE_ERROR_FLAGS_MOTOR_ERROR = ProtoField.bool("mavlink_proto.GIMBAL_DEVICE_ATTITUDE_STATUS_failure_flags.GIMBAL_DEVICE_ERROR_FLAGS_MOTOR_ERROR", "GIMBAL_DEVICE_ERROR_FLAGS_MOTOR_ERROR", 12, nil, 32)
f.GIMBAL_DEVICE_ATTITUDE_STATUS_failure_flags_flagGIMBAL_DEVICE_ERROR_FLAGS_SOFTWARE_ERROR = ProtoField.bool("mavlink_proto.GIMBAL_DEVICE_ATTITUDE_STATUS_failure_flags.GIMBAL_DEVICE_ERROR_FLAGS_SOFTWARE_ERROR", "GIMBAL_DEVICE_ERROR_FLAGS_SOFTWARE_ERROR", 12, nil, 64)
f.GIMBAL_DEVICE_ATTITUDE_STATUS_failure_flags_flagGIMBAL_DEVICE_ERROR_FLAGS_COMMS_ERROR = ProtoField.bool("mavlink_proto.GIMBAL_DEVICE_ATTITUDE_STATUS_failure_flags.GIMBAL_DEVICE_ERROR_FLAGS_COMMS_ERROR", "GIMBAL_DEVICE_ERROR_FLAGS_COMMS_ERROR", 12, nil, 128)
f.GIMBAL_DEVICE_ATTITUDE_STATUS_failure_flags_flagGIMBAL_DEVICE_ERROR_FLAGS_CALIBRATION_RUNNING = ProtoField.bool("mavlink_proto.GIMBAL_DEVICE_ATTITUDE_STATUS_failure_flags.GIMBAL_DEVICE_ERROR_FLAGS_CALIBRATION_RUNNING", "GIMBAL_DEVICE_ERROR_FLAGS_CALIBRATION_RUNNING", 12, nil, 256)
f.GIMBAL_DEVICE_ATTITUDE_STATUS_failure_flags_flagGIMBAL_DEVICE_ERROR_FLAGS_NO_MANAGER = ProtoField.bool("mavlink_proto.GIMBAL_DEVICE_ATTITUDE_STATUS_failure_flags.GIMBAL_DEVICE_ERROR_FLAGS_NO_MANAGER", "GIMBAL_DEVICE_ERROR_FLAGS_NO_MANAGER", 12, nil, 512)
f.GIMBAL_DEVICE_ATTITUDE_STATUS_delta_yaw = ProtoField.new("delta_yaw (float) [rad]", "mavlink_proto.GIMBAL_DEVICE_ATTITUDE_STATUS_delta_yaw", ftypes.FLOAT, nil)
f.GIMBAL_DEVICE_ATTITUDE_STATUS_delta_yaw_velocity = ProtoField.new("delta_yaw_velocity (float) [rad/s]", "mavlink_proto.GIMBAL_DEVICE_ATTITUDE_STATUS_delta_yaw_velocity", ftypes.FLOAT, nil)
f.GIMBAL_DEVICE_ATTITUDE_STATUS_gimbal_device_id = ProtoField.new("gimbal_device_id (uint8_t)", "mavlink_proto.GIMBAL_DEVICE_ATTITUDE_STATUS_gimbal_device_id", ftypes.UINT8, nil)

f.AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_target_system = ProtoField.new("target_system (uint8_t)", "mavlink_proto.AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_target_system", ftypes.UINT8, nil)
f.AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_target_component = ProtoField.new("target_component (uint8_t)", "mavlink_proto.AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_target_component", ftypes.UINT8, nil)
f.AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_time_boot_us = ProtoField.new("time_boot_us (uint64_t) [us]", "mavlink_proto.AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_time_boot_us", ftypes.UINT64, nil)
for i = 0, 3 do
    f["AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_q_"..i] = ProtoField.new("q["..i.."] (float)", "mavlink_proto.AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_q_"..i, ftypes.FLOAT, nil)
end
f.AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_q_estimated_delay_us = ProtoField.new("q_estimated_delay_us (uint32_t) [us]", "mavlink_proto.AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_q_estimated_delay_us", ftypes.UINT32, nil)
f.AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_vx = ProtoField.new("vx (float) [m/s]", "mavlink_proto.AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_vx", ftypes.FLOAT, nil)
f.AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_vy = ProtoField.new("vy (float) [m/s]", "mavlink_proto.AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_vy", ftypes.FLOAT, nil)
f.AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_vz = ProtoField.new("vz (float) [m/s]", "mavlink_proto.AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_vz", ftypes.FLOAT, nil)
f.AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_v_estimated_delay_us = ProtoField.new("v_estimated_delay_us (uint32_t) [us]", "mavlink_proto.AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_v_estimated_delay_us", ftypes.UINT32, nil)
f.AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_feed_forward_angular_velocity_z = ProtoField.new("feed_forward_angular_velocity_z (float) [rad/s]", "mavlink_proto.AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_feed_forward_angular_velocity_z", ftypes.FLOAT, nil)
f.AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_estimator_status = ProtoField.new("estimator_status (ESTIMATOR_STATUS_FLAGS)", "mavlink_proto.AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_estimator_status", ftypes.UINT16, nil, base.HEX_DEC)
f.AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_estimator_status_flagESTIMATOR_ATTITUDE = ProtoField.bool("mavlink_proto.AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_estimator_status.ESTIMATOR_ATTITUDE", "ESTIMATOR_ATTITUDE", 12, nil, 1)
f.AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_estimator_status_flagESTIMATOR_VELOCITY_HORIZ = ProtoField.bool("mavlink_proto.AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_estimator_status.ESTIMATOR_VELOCITY_HORIZ", "ESTIMATOR_VELOCITY_HORIZ", 12, nil, 2)
f.AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_estimator_status_flagESTIMATOR_VELOCITY_VERT = ProtoField.bool("mavlink_proto.AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_estimator_status.ESTIMATOR_VELOCITY_VERT", "ESTIMATOR_VELOCITY_VERT", 12, nil, 4)
f.AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_estimator_status_flagESTIMATOR_POS_HORIZ_REL = ProtoField.bool("mavlink_proto.AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_estimator_status.ESTIMATOR_POS_HORIZ_REL", "ESTIMATOR_POS_HORIZ_REL", 12, nil, 8)
f.AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_estimator_status_flagESTIMATOR_POS_HORIZ_ABS = ProtoField.bool("mavlink_proto.AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_estimator_status.ESTIMATOR_POS_HORIZ_ABS", "ESTIMATOR_POS_HORIZ_ABS", 12, nil, 16)
f.AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_estimator_status_flagESTIMATOR_POS_VERT_ABS = ProtoField.bool("mavlink_proto.AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_estimator_status.ESTIMATOR_POS_VERT_ABS", "ESTIMATOR_POS_VERT_ABS", 12, nil, 32)
f.AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_estimator_status_flagESTIMATOR_POS_VERT_AGL = ProtoField.bool("mavlink_proto.AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_estimator_status.ESTIMATOR_POS_VERT_AGL", "ESTIMATOR_POS_VERT_AGL", 12, nil, 64)
f.AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_estimator_status_flagESTIMATOR_CONST_POS_MODE = ProtoField.bool("mavlink_proto.AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_estimator_status.ESTIMATOR_CONST_POS_MODE", "ESTIMATOR_CONST_POS_MODE", 12, nil, 128)
f.AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_estimator_status_flagESTIMATOR_PRED_POS_HORIZ_REL = ProtoField.bool("mavlink_proto.AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_estimator_status.ESTIMATOR_PRED_POS_HORIZ_REL", "ESTIMATOR_PRED_POS_HORIZ_REL", 12, nil, 256)
f.AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_estimator_status_flagESTIMATOR_PRED_POS_HORIZ_ABS = ProtoField.bool("mavlink_proto.AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_estimator_status.ESTIMATOR_PRED_POS_HORIZ_ABS", "ESTIMATOR_PRED_POS_HORIZ_ABS", 12, nil, 512)
f.AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_estimator_status_flagESTIMATOR_GPS_GLITCH = ProtoField.bool("mavlink_proto.AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_estimator_status.ESTIMATOR_GPS_GLITCH", "ESTIMATOR_GPS_GLITCH", 12, nil, 1024)
f.AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_estimator_status_flagESTIMATOR_ACCEL_ERROR = ProtoField.bool("mavlink_proto.AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_estimator_status.ESTIMATOR_ACCEL_ERROR", "ESTIMATOR_ACCEL_ERROR", 12, nil, 2048)
f.AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_landed_state = ProtoField.new("landed_state (MAV_LANDED_STATE)", "mavlink_proto.AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_landed_state", ftypes.UINT8, enumEntryName.MAV_LANDED_STATE)
f.AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_angular_velocity_z = ProtoField.new("angular_velocity_z (float) [rad/s]", "mavlink_proto.AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_angular_velocity_z", ftypes.FLOAT, nil)

f.GIMBAL_MANAGER_SET_PITCHYAW_target_system = ProtoField.new("target_system (uint8_t)", "mavlink_proto.GIMBAL_MANAGER_SET_PITCHYAW_target_system", ftypes.UINT8, nil)
f.GIMBAL_MANAGER_SET_PITCHYAW_target_component = ProtoField.new("target_component (uint8_t)", "mavlink_proto.GIMBAL_MANAGER_SET_PITCHYAW_target_component", ftypes.UINT8, nil)
f.GIMBAL_MANAGER_SET_PITCHYAW_flags = ProtoField.new("flags (GIMBAL_MANAGER_FLAGS)", "mavlink_proto.GIMBAL_MANAGER_SET_PITCHYAW_flags", ftypes.UINT32, nil, base.HEX_DEC)
f.GIMBAL_MANAGER_SET_PITCHYAW_flags_flagGIMBAL_MANAGER_FLAGS_RETRACT = ProtoField.bool("mavlink_proto.GIMBAL_MANAGER_SET_PITCHYAW_flags.GIMBAL_MANAGER_FLAGS_RETRACT", "GIMBAL_MANAGER_FLAGS_RETRACT", 12, nil, 1)
f.GIMBAL_MANAGER_SET_PITCHYAW_flags_flagGIMBAL_MANAGER_FLAGS_NEUTRAL = ProtoField.bool("mavlink_proto.GIMBAL_MANAGER_SET_PITCHYAW_flags.GIMBAL_MANAGER_FLAGS_NEUTRAL", "GIMBAL_MANAGER_FLAGS_NEUTRAL", 12, nil, 2)
f.GIMBAL_MANAGER_SET_PITCHYAW_flags_flagGIMBAL_MANAGER_FLAGS_ROLL_LOCK = ProtoField.bool("mavlink_proto.GIMBAL_MANAGER_SET_PITCHYAW_flags.GIMBAL_MANAGER_FLAGS_ROLL_LOCK", "GIMBAL_MANAGER_FLAGS_ROLL_LOCK", 12, nil, 4)
f.GIMBAL_MANAGER_SET_PITCHYAW_flags_flagGIMBAL_MANAGER_FLAGS_PITCH_LOCK = ProtoField.bool("mavlink_proto.GIMBAL_MANAGER_SET_PITCHYAW_flags.GIMBAL_MANAGER_FLAGS_PITCH_LOCK", "GIMBAL_MANAGER_FLAGS_PITCH_LOCK", 12, nil, 8)
f.GIMBAL_MANAGER_SET_PITCHYAW_flags_flagGIMBAL_MANAGER_FLAGS_YAW_LOCK = ProtoField.bool("mavlink_proto.GIMBAL_MANAGER_SET_PITCHYAW_flags.GIMBAL_MANAGER_FLAGS_YAW_LOCK", "GIMBAL_MANAGER_FLAGS_YAW_LOCK", 12, nil, 16)
f.GIMBAL_MANAGER_SET_PITCHYAW_flags_flagGIMBAL_MANAGER_FLAGS_YAW_IN_VEHICLE_FRAME = ProtoField.bool("mavlink_proto.GIMBAL_MANAGER_SET_PITCHYAW_flags.GIMBAL_MANAGER_FLAGS_YAW_IN_VEHICLE_FRAME", "GIMBAL_MANAGER_FLAGS_YAW_IN_VEHICLE_FRAME", 12, nil, 32)
f.GIMBAL_MANAGER_SET_PITCHYAW_flags_flagGIMBAL_MANAGER_FLAGS_YAW_IN_EARTH_FRAME = ProtoField.bool("mavlink_proto.GIMBAL_MANAGER_SET_PITCHYAW_flags.GIMBAL_MANAGER_FLAGS_YAW_IN_EARTH_FRAME", "GIMBAL_MANAGER_FLAGS_YAW_IN_EARTH_FRAME", 12, nil, 64)
f.GIMBAL_MANAGER_SET_PITCHYAW_flags_flagGIMBAL_MANAGER_FLAGS_ACCEPTS_YAW_IN_EARTH_FRAME = ProtoField.bool("mavlink_proto.GIMBAL_MANAGER_SET_PITCHYAW_flags.GIMBAL_MANAGER_FLAGS_ACCEPTS_YAW_IN_EARTH_FRAME", "GIMBAL_MANAGER_FLAGS_ACCEPTS_YAW_IN_EARTH_FRAME", 12, nil, 128)
f.GIMBAL_MANAGER_SET_PITCHYAW_flags_flagGIMBAL_MANAGER_FLAGS_RC_EXCLUSIVE = ProtoField.bool("mavlink_proto.GIMBAL_MANAGER_SET_PITCHYAW_flags.GIMBAL_MANAGER_FLAGS_RC_EXCLUSIVE", "GIMBAL_MANAGER_FLAGS_RC_EXCLUSIVE", 12, nil, 256)
f.GIMBAL_MANAGER_SET_PITCHYAW_flags_flagGIMBAL_MANAGER_FLAGS_RC_MIXED = ProtoField.bool("mavlink_proto.GIMBAL_MANAGER_SET_PITCHYAW_flags.GIMBAL_MANAGER_FLAGS_RC_MIXED", "GIMBAL_MANAGER_FLAGS_RC_MIXED", 12, nil, 512)
f.GIMBAL_MANAGER_SET_PITCHYAW_gimbal_device_id = ProtoField.new("gimbal_device_id (uint8_t)", "mavlink_proto.GIMBAL_MANAGER_SET_PITCHYAW_gimbal_device_id", ftypes.UINT8, nil)
f.GIMBAL_MANAGER_SET_PITCHYAW_pitch = ProtoField.new("pitch (float) [rad]", "mavlink_proto.GIMBAL_MANAGER_SET_PITCHYAW_pitch", ftypes.FLOAT, nil)
f.GIMBAL_MANAGER_SET_PITCHYAW_yaw = ProtoField.new("yaw (float) [rad]", "mavlink_proto.GIMBAL_MANAGER_SET_PITCHYAW_yaw", ftypes.FLOAT, nil)
f.GIMBAL_MANAGER_SET_PITCHYAW_pitch_rate = ProtoField.new("pitch_rate (float) [rad/s]", "mavlink_proto.GIMBAL_MANAGER_SET_PITCHYAW_pitch_rate", ftypes.FLOAT, nil)
f.GIMBAL_MANAGER_SET_PITCHYAW_yaw_rate = ProtoField.new("yaw_rate (float) [rad/s]", "mavlink_proto.GIMBAL_MANAGER_SET_PITCHYAW_yaw_rate", ftypes.FLOAT, nil)

f.PARAM_ERROR_target_system = ProtoField.new("target_system (uint8_t)", "mavlink_proto.PARAM_ERROR_target_system", ftypes.UINT8, nil)
f.PARAM_ERROR_target_component = ProtoField.new("target_component (uint8_t)", "mavlink_proto.PARAM_ERROR_target_component", ftypes.UINT8, nil)
f.PARAM_ERROR_param_id = ProtoField.new("param_id (char)", "mavlink_proto.PARAM_ERROR_param_id", ftypes.STRING, nil)
f.PARAM_ERROR_param_index = ProtoField.new("param_index (int16_t)", "mavlink_proto.PARAM_ERROR_param_index", ftypes.INT16, nil)
f.PARAM_ERROR_error = ProtoField.new("error (MAV_PARAM_ERROR)", "mavlink_proto.PARAM_ERROR_error", ftypes.UINT8, enumEntryName.MAV_PARAM_ERROR)

f.DEBUG_FLOAT_ARRAY_time_usec = ProtoField.new("time_usec (uint64_t) [us]", "mavlink_proto.DEBUG_FLOAT_ARRAY_time_usec", ftypes.UINT64, nil)
f.DEBUG_FLOAT_ARRAY_name = ProtoField.new("name (char)", "mavlink_proto.DEBUG_FLOAT_ARRAY_name", ftypes.STRING, nil)
f.DEBUG_FLOAT_ARRAY_array_id = ProtoField.new("array_id (uint16_t)", "mavlink_proto.DEBUG_FLOAT_ARRAY_array_id", ftypes.UINT16, nil)
for i = 0, 57 do
    f["DEBUG_FLOAT_ARRAY_data_"..i] = ProtoField.new("data["..i.."] (float)", "mavlink_proto.DEBUG_FLOAT_ARRAY_data_"..i, ftypes.FLOAT, nil)
end

f.TUNNEL_target_system = ProtoField.new("target_system (uint8_t)", "mavlink_proto.TUNNEL_target_system", ftypes.UINT8, nil)
f.TUNNEL_target_component = ProtoField.new("target_component (uint8_t)", "mavlink_proto.TUNNEL_target_component", ftypes.UINT8, nil)
f.TUNNEL_payload_type = ProtoField.new("payload_type (MAV_TUNNEL_PAYLOAD_TYPE)", "mavlink_proto.TUNNEL_payload_type", ftypes.UINT16, enumEntryName.MAV_TUNNEL_PAYLOAD_TYPE)
f.TUNNEL_payload_length = ProtoField.new("payload_length (uint8_t)", "mavlink_proto.TUNNEL_payload_length", ftypes.UINT8, nil)
for i = 0, 127 do
    f["TUNNEL_payload_"..i] = ProtoField.new("payload["..i.."] (uint8_t)", "mavlink_proto.TUNNEL_payload_"..i, ftypes.UINT8, nil)
end

f.ONBOARD_COMPUTER_STATUS_time_usec = ProtoField.new("time_usec (uint64_t) [us]", "mavlink_proto.ONBOARD_COMPUTER_STATUS_time_usec", ftypes.UINT64, nil)
f.ONBOARD_COMPUTER_STATUS_uptime = ProtoField.new("uptime (uint32_t) [ms]", "mavlink_proto.ONBOARD_COMPUTER_STATUS_uptime", ftypes.UINT32, nil)
f.ONBOARD_COMPUTER_STATUS_type = ProtoField.new("type (uint8_t)", "mavlink_proto.ONBOARD_COMPUTER_STATUS_type", ftypes.UINT8, nil)
for i = 0, 7 do
    f["ONBOARD_COMPUTER_STATUS_cpu_cores_"..i] = ProtoField.new("cpu_cores["..i.."] (uint8_t)", "mavlink_proto.ONBOARD_COMPUTER_STATUS_cpu_cores_"..i, ftypes.UINT8, nil)
end
for i = 0, 9 do
    f["ONBOARD_COMPUTER_STATUS_cpu_combined_"..i] = ProtoField.new("cpu_combined["..i.."] (uint8_t)", "mavlink_proto.ONBOARD_COMPUTER_STATUS_cpu_combined_"..i, ftypes.UINT8, nil)
end
for i = 0, 3 do
    f["ONBOARD_COMPUTER_STATUS_gpu_cores_"..i] = ProtoField.new("gpu_cores["..i.."] (uint8_t)", "mavlink_proto.ONBOARD_COMPUTER_STATUS_gpu_cores_"..i, ftypes.UINT8, nil)
end
for i = 0, 9 do
    f["ONBOARD_COMPUTER_STATUS_gpu_combined_"..i] = ProtoField.new("gpu_combined["..i.."] (uint8_t)", "mavlink_proto.ONBOARD_COMPUTER_STATUS_gpu_combined_"..i, ftypes.UINT8, nil)
end
f.ONBOARD_COMPUTER_STATUS_temperature_board = ProtoField.new("temperature_board (int8_t) [degC]", "mavlink_proto.ONBOARD_COMPUTER_STATUS_temperature_board", ftypes.INT8, nil)
for i = 0, 7 do
    f["ONBOARD_COMPUTER_STATUS_temperature_core_"..i] = ProtoField.new("temperature_core["..i.."] (int8_t) [degC]", "mavlink_proto.ONBOARD_COMPUTER_STATUS_temperature_core_"..i, ftypes.INT8, nil)
end
for i = 0, 3 do
    f["ONBOARD_COMPUTER_STATUS_fan_speed_"..i] = ProtoField.new("fan_speed["..i.."] (int16_t) [rpm]", "mavlink_proto.ONBOARD_COMPUTER_STATUS_fan_speed_"..i, ftypes.INT16, nil)
end
f.ONBOARD_COMPUTER_STATUS_ram_usage = ProtoField.new("ram_usage (uint32_t) [MiB]", "mavlink_proto.ONBOARD_COMPUTER_STATUS_ram_usage", ftypes.UINT32, nil)
f.ONBOARD_COMPUTER_STATUS_ram_total = ProtoField.new("ram_total (uint32_t) [MiB]", "mavlink_proto.ONBOARD_COMPUTER_STATUS_ram_total", ftypes.UINT32, nil)
for i = 0, 3 do
    f["ONBOARD_COMPUTER_STATUS_storage_type_"..i] = ProtoField.new("storage_type["..i.."] (uint32_t)", "mavlink_proto.ONBOARD_COMPUTER_STATUS_storage_type_"..i, ftypes.UINT32, nil)
end
for i = 0, 3 do
    f["ONBOARD_COMPUTER_STATUS_storage_usage_"..i] = ProtoField.new("storage_usage["..i.."] (uint32_t) [MiB]", "mavlink_proto.ONBOARD_COMPUTER_STATUS_storage_usage_"..i, ftypes.UINT32, nil)
end
for i = 0, 3 do
    f["ONBOARD_COMPUTER_STATUS_storage_total_"..i] = ProtoField.new("storage_total["..i.."] (uint32_t) [MiB]", "mavlink_proto.ONBOARD_COMPUTER_STATUS_storage_total_"..i, ftypes.UINT32, nil)
end
for i = 0, 5 do
    f["ONBOARD_COMPUTER_STATUS_link_type_"..i] = ProtoField.new("link_type["..i.."] (uint32_t)", "mavlink_proto.ONBOARD_COMPUTER_STATUS_link_type_"..i, ftypes.UINT32, nil)
end
for i = 0, 5 do
    f["ONBOARD_COMPUTER_STATUS_link_tx_rate_"..i] = ProtoField.new("link_tx_rate["..i.."] (uint32_t) [KiB/s]", "mavlink_proto.ONBOARD_COMPUTER_STATUS_link_tx_rate_"..i, ftypes.UINT32, nil)
end
for i = 0, 5 do
    f["ONBOARD_COMPUTER_STATUS_link_rx_rate_"..i] = ProtoField.new("link_rx_rate["..i.."] (uint32_t) [KiB/s]", "mavlink_proto.ONBOARD_COMPUTER_STATUS_link_rx_rate_"..i, ftypes.UINT32, nil)
end
for i = 0, 5 do
    f["ONBOARD_COMPUTER_STATUS_link_tx_max_"..i] = ProtoField.new("link_tx_max["..i.."] (uint32_t) [KiB/s]", "mavlink_proto.ONBOARD_COMPUTER_STATUS_link_tx_max_"..i, ftypes.UINT32, nil)
end
for i = 0, 5 do
    f["ONBOARD_COMPUTER_STATUS_link_rx_max_"..i] = ProtoField.new("link_rx_max["..i.."] (uint32_t) [KiB/s]", "mavlink_proto.ONBOARD_COMPUTER_STATUS_link_rx_max_"..i, ftypes.UINT32, nil)
end
f.ONBOARD_COMPUTER_STATUS_status_flags = ProtoField.new("status_flags (COMPUTER_STATUS_FLAGS)", "mavlink_proto.ONBOARD_COMPUTER_STATUS_status_flags", ftypes.UINT16, nil, base.HEX_DEC)
f.ONBOARD_COMPUTER_STATUS_status_flags_flagCOMPUTER_STATUS_FLAGS_UNDER_VOLTAGE = ProtoField.bool("mavlink_proto.ONBOARD_COMPUTER_STATUS_status_flags.COMPUTER_STATUS_FLAGS_UNDER_VOLTAGE", "COMPUTER_STATUS_FLAGS_UNDER_VOLTAGE", 4, nil, 1)
f.ONBOARD_COMPUTER_STATUS_status_flags_flagCOMPUTER_STATUS_FLAGS_CPU_THROTTLE = ProtoField.bool("mavlink_proto.ONBOARD_COMPUTER_STATUS_status_flags.COMPUTER_STATUS_FLAGS_CPU_THROTTLE", "COMPUTER_STATUS_FLAGS_CPU_THROTTLE", 4, nil, 2)
f.ONBOARD_COMPUTER_STATUS_status_flags_flagCOMPUTER_STATUS_FLAGS_THERMAL_THROTTLE = ProtoField.bool("mavlink_proto.ONBOARD_COMPUTER_STATUS_status_flags.COMPUTER_STATUS_FLAGS_THERMAL_THROTTLE", "COMPUTER_STATUS_FLAGS_THERMAL_THROTTLE", 4, nil, 4)
f.ONBOARD_COMPUTER_STATUS_status_flags_flagCOMPUTER_STATUS_FLAGS_DISK_FULL = ProtoField.bool("mavlink_proto.ONBOARD_COMPUTER_STATUS_status_flags.COMPUTER_STATUS_FLAGS_DISK_FULL", "COMPUTER_STATUS_FLAGS_DISK_FULL", 4, nil, 8)

-- dissect flag field
function dissect_flags_ROSS_STATUS_FLAGS(tree, name, tvbrange, value)
    tree:add_le(f[name .. "_flagROSS_STATUS_FLAGS_NOISE_MEASURED"], tvbrange, value)
    tree:add_le(f[name .. "_flagROSS_STATUS_FLAGS_CERTAIN"], tvbrange, value)
    tree:add_le(f[name .. "_flagROSS_STATUS_FLAGS_TARGET_FOUND"], tvbrange, value)
    tree:add_le(f[name .. "_flagROSS_STATUS_FLAGS_TIME_UNIX"], tvbrange, value)
    tree:add_le(f[name .. "_flagROSS_STATUS_FLAGS_STREAMING"], tvbrange, value)
    tree:add_le(f[name .. "_flagROSS_STATUS_FLAGS_RECORDING"], tvbrange, value)
end
-- dissect flag field
function dissect_flags_ROSS_ACTUATOR_FLAGS(tree, name, tvbrange, value)
    tree:add_le(f[name .. "_flagROSS_ACTUATOR_FLAGS_PRESENT"], tvbrange, value)
    tree:add_le(f[name .. "_flagROSS_ACTUATOR_FLAGS_SETTLED"], tvbrange, value)
    tree:add_le(f[name .. "_flagROSS_ACTUATOR_FLAGS_HOMED"], tvbrange, value)
    tree:add_le(f[name .. "_flagROSS_ACTUATOR_FLAGS_FAULT"], tvbrange, value)
    tree:add_le(f[name .. "_flagROSS_ACTUATOR_FLAGS_OPEN_LOOP"], tvbrange, value)
end
-- dissect flag field
function dissect_flags_ROSS_SOURCE_FLAGS(tree, name, tvbrange, value)
    tree:add_le(f[name .. "_flagROSS_SOURCE_FLAGS_RESOLVED"], tvbrange, value)
    tree:add_le(f[name .. "_flagROSS_SOURCE_FLAGS_TARGET"], tvbrange, value)
    tree:add_le(f[name .. "_flagROSS_SOURCE_FLAGS_FINAL"], tvbrange, value)
    tree:add_le(f[name .. "_flagROSS_SOURCE_FLAGS_TRACKED"], tvbrange, value)
end
-- dissect flag field
function dissect_flags_ROSS_GROUP_FLAGS(tree, name, tvbrange, value)
    tree:add_le(f[name .. "_flagROSS_GROUP_FLAGS_ACCEPTED"], tvbrange, value)
    tree:add_le(f[name .. "_flagROSS_GROUP_FLAGS_TARGET"], tvbrange, value)
end
-- dissect flag field
function dissect_flags_ROSS_AUDIO_TROUBLE(tree, name, tvbrange, value)
    tree:add_le(f[name .. "_flagROSS_AUDIO_TROUBLE_CLIPPING"], tvbrange, value)
    tree:add_le(f[name .. "_flagROSS_AUDIO_TROUBLE_DEAD_1"], tvbrange, value)
    tree:add_le(f[name .. "_flagROSS_AUDIO_TROUBLE_DEAD_2"], tvbrange, value)
    tree:add_le(f[name .. "_flagROSS_AUDIO_TROUBLE_OFFSET"], tvbrange, value)
    tree:add_le(f[name .. "_flagROSS_AUDIO_TROUBLE_IDENTICAL"], tvbrange, value)
    tree:add_le(f[name .. "_flagROSS_AUDIO_TROUBLE_INVERTED"], tvbrange, value)
    tree:add_le(f[name .. "_flagROSS_AUDIO_TROUBLE_LOST"], tvbrange, value)
    tree:add_le(f[name .. "_flagROSS_AUDIO_TROUBLE_ABSENT"], tvbrange, value)
end
-- dissect flag field
function dissect_flags_ROSS_STREAM_FLAGS(tree, name, tvbrange, value)
    tree:add_le(f[name .. "_flagROSS_STREAM_FLAGS_ON"], tvbrange, value)
    tree:add_le(f[name .. "_flagROSS_STREAM_FLAGS_FAULT"], tvbrange, value)
    tree:add_le(f[name .. "_flagROSS_STREAM_FLAGS_MUTED"], tvbrange, value)
    tree:add_le(f[name .. "_flagROSS_STREAM_FLAGS_RECORDS"], tvbrange, value)
    tree:add_le(f[name .. "_flagROSS_STREAM_FLAGS_SEPARATED"], tvbrange, value)
end
-- dissect flag field
function dissect_flags_ROSS_LINK_FLAGS(tree, name, tvbrange, value)
    tree:add_le(f[name .. "_flagROSS_LINK_FLAGS_UP"], tvbrange, value)
    tree:add_le(f[name .. "_flagROSS_LINK_FLAGS_AUTOPILOT"], tvbrange, value)
end
-- dissect flag field
function dissect_flags_MAV_MODE_FLAG(tree, name, tvbrange, value)
    tree:add_le(f[name .. "_flagMAV_MODE_FLAG_CUSTOM_MODE_ENABLED"], tvbrange, value)
    tree:add_le(f[name .. "_flagMAV_MODE_FLAG_TEST_ENABLED"], tvbrange, value)
    tree:add_le(f[name .. "_flagMAV_MODE_FLAG_AUTO_ENABLED"], tvbrange, value)
    tree:add_le(f[name .. "_flagMAV_MODE_FLAG_GUIDED_ENABLED"], tvbrange, value)
    tree:add_le(f[name .. "_flagMAV_MODE_FLAG_STABILIZE_ENABLED"], tvbrange, value)
    tree:add_le(f[name .. "_flagMAV_MODE_FLAG_HIL_ENABLED"], tvbrange, value)
    tree:add_le(f[name .. "_flagMAV_MODE_FLAG_MANUAL_INPUT_ENABLED"], tvbrange, value)
    tree:add_le(f[name .. "_flagMAV_MODE_FLAG_SAFETY_ARMED"], tvbrange, value)
end
-- dissect flag field
function dissect_flags_MAV_PROTOCOL_CAPABILITY(tree, name, tvbrange, value)
    tree:add_le(f[name .. "_flagMAV_PROTOCOL_CAPABILITY_MISSION_FLOAT"], tvbrange, value)
    tree:add_le(f[name .. "_flagMAV_PROTOCOL_CAPABILITY_PARAM_FLOAT"], tvbrange, value)
    tree:add_le(f[name .. "_flagMAV_PROTOCOL_CAPABILITY_MISSION_INT"], tvbrange, value)
    tree:add_le(f[name .. "_flagMAV_PROTOCOL_CAPABILITY_COMMAND_INT"], tvbrange, value)
    tree:add_le(f[name .. "_flagMAV_PROTOCOL_CAPABILITY_PARAM_ENCODE_BYTEWISE"], tvbrange, value)
    tree:add_le(f[name .. "_flagMAV_PROTOCOL_CAPABILITY_FTP"], tvbrange, value)
    tree:add_le(f[name .. "_flagMAV_PROTOCOL_CAPABILITY_SET_ATTITUDE_TARGET"], tvbrange, value)
    tree:add_le(f[name .. "_flagMAV_PROTOCOL_CAPABILITY_SET_POSITION_TARGET_LOCAL_NED"], tvbrange, value)
    tree:add_le(f[name .. "_flagMAV_PROTOCOL_CAPABILITY_SET_POSITION_TARGET_GLOBAL_INT"], tvbrange, value)
    tree:add_le(f[name .. "_flagMAV_PROTOCOL_CAPABILITY_TERRAIN"], tvbrange, value)
    tree:add_le(f[name .. "_flagMAV_PROTOCOL_CAPABILITY_RESERVED3"], tvbrange, value)
    tree:add_le(f[name .. "_flagMAV_PROTOCOL_CAPABILITY_FLIGHT_TERMINATION"], tvbrange, value)
    tree:add_le(f[name .. "_flagMAV_PROTOCOL_CAPABILITY_COMPASS_CALIBRATION"], tvbrange, value)
    tree:add_le(f[name .. "_flagMAV_PROTOCOL_CAPABILITY_MAVLINK2"], tvbrange, value)
    tree:add_le(f[name .. "_flagMAV_PROTOCOL_CAPABILITY_MISSION_FENCE"], tvbrange, value)
    tree:add_le(f[name .. "_flagMAV_PROTOCOL_CAPABILITY_MISSION_RALLY"], tvbrange, value)
    tree:add_le(f[name .. "_flagMAV_PROTOCOL_CAPABILITY_RESERVED2"], tvbrange, value)
    tree:add_le(f[name .. "_flagMAV_PROTOCOL_CAPABILITY_PARAM_ENCODE_C_CAST"], tvbrange, value)
    tree:add_le(f[name .. "_flagMAV_PROTOCOL_CAPABILITY_COMPONENT_IMPLEMENTS_GIMBAL_MANAGER"], tvbrange, value)
    tree:add_le(f[name .. "_flagMAV_PROTOCOL_CAPABILITY_COMPONENT_ACCEPTS_GCS_CONTROL"], tvbrange, value)
    tree:add_le(f[name .. "_flagMAV_PROTOCOL_CAPABILITY_GRIPPER"], tvbrange, value)
end
-- dissect flag field
function dissect_flags_GIMBAL_DEVICE_CAP_FLAGS(tree, name, tvbrange, value)
    tree:add_le(f[name .. "_flagGIMBAL_DEVICE_CAP_FLAGS_HAS_RETRACT"], tvbrange, value)
    tree:add_le(f[name .. "_flagGIMBAL_DEVICE_CAP_FLAGS_HAS_NEUTRAL"], tvbrange, value)
    tree:add_le(f[name .. "_flagGIMBAL_DEVICE_CAP_FLAGS_HAS_ROLL_AXIS"], tvbrange, value)
    tree:add_le(f[name .. "_flagGIMBAL_DEVICE_CAP_FLAGS_HAS_ROLL_FOLLOW"], tvbrange, value)
    tree:add_le(f[name .. "_flagGIMBAL_DEVICE_CAP_FLAGS_HAS_ROLL_LOCK"], tvbrange, value)
    tree:add_le(f[name .. "_flagGIMBAL_DEVICE_CAP_FLAGS_HAS_PITCH_AXIS"], tvbrange, value)
    tree:add_le(f[name .. "_flagGIMBAL_DEVICE_CAP_FLAGS_HAS_PITCH_FOLLOW"], tvbrange, value)
    tree:add_le(f[name .. "_flagGIMBAL_DEVICE_CAP_FLAGS_HAS_PITCH_LOCK"], tvbrange, value)
    tree:add_le(f[name .. "_flagGIMBAL_DEVICE_CAP_FLAGS_HAS_YAW_AXIS"], tvbrange, value)
    tree:add_le(f[name .. "_flagGIMBAL_DEVICE_CAP_FLAGS_HAS_YAW_FOLLOW"], tvbrange, value)
    tree:add_le(f[name .. "_flagGIMBAL_DEVICE_CAP_FLAGS_HAS_YAW_LOCK"], tvbrange, value)
    tree:add_le(f[name .. "_flagGIMBAL_DEVICE_CAP_FLAGS_SUPPORTS_INFINITE_YAW"], tvbrange, value)
    tree:add_le(f[name .. "_flagGIMBAL_DEVICE_CAP_FLAGS_SUPPORTS_YAW_IN_EARTH_FRAME"], tvbrange, value)
    tree:add_le(f[name .. "_flagGIMBAL_DEVICE_CAP_FLAGS_HAS_RC_INPUTS"], tvbrange, value)
    tree:add_le(f[name .. "_flagGIMBAL_DEVICE_CAP_FLAGS_CAN_POINT_LOCATION_LOCAL"], tvbrange, value)
    tree:add_le(f[name .. "_flagGIMBAL_DEVICE_CAP_FLAGS_CAN_POINT_LOCATION_GLOBAL"], tvbrange, value)
end
-- dissect flag field
function dissect_flags_GIMBAL_MANAGER_CAP_FLAGS(tree, name, tvbrange, value)
    tree:add_le(f[name .. "_flagGIMBAL_MANAGER_CAP_FLAGS_HAS_RETRACT"], tvbrange, value)
    tree:add_le(f[name .. "_flagGIMBAL_MANAGER_CAP_FLAGS_HAS_NEUTRAL"], tvbrange, value)
    tree:add_le(f[name .. "_flagGIMBAL_MANAGER_CAP_FLAGS_HAS_ROLL_AXIS"], tvbrange, value)
    tree:add_le(f[name .. "_flagGIMBAL_MANAGER_CAP_FLAGS_HAS_ROLL_FOLLOW"], tvbrange, value)
    tree:add_le(f[name .. "_flagGIMBAL_MANAGER_CAP_FLAGS_HAS_ROLL_LOCK"], tvbrange, value)
    tree:add_le(f[name .. "_flagGIMBAL_MANAGER_CAP_FLAGS_HAS_PITCH_AXIS"], tvbrange, value)
    tree:add_le(f[name .. "_flagGIMBAL_MANAGER_CAP_FLAGS_HAS_PITCH_FOLLOW"], tvbrange, value)
    tree:add_le(f[name .. "_flagGIMBAL_MANAGER_CAP_FLAGS_HAS_PITCH_LOCK"], tvbrange, value)
    tree:add_le(f[name .. "_flagGIMBAL_MANAGER_CAP_FLAGS_HAS_YAW_AXIS"], tvbrange, value)
    tree:add_le(f[name .. "_flagGIMBAL_MANAGER_CAP_FLAGS_HAS_YAW_FOLLOW"], tvbrange, value)
    tree:add_le(f[name .. "_flagGIMBAL_MANAGER_CAP_FLAGS_HAS_YAW_LOCK"], tvbrange, value)
    tree:add_le(f[name .. "_flagGIMBAL_MANAGER_CAP_FLAGS_SUPPORTS_INFINITE_YAW"], tvbrange, value)
    tree:add_le(f[name .. "_flagGIMBAL_MANAGER_CAP_FLAGS_SUPPORTS_YAW_IN_EARTH_FRAME"], tvbrange, value)
    tree:add_le(f[name .. "_flagGIMBAL_MANAGER_CAP_FLAGS_HAS_RC_INPUTS"], tvbrange, value)
    tree:add_le(f[name .. "_flagGIMBAL_MANAGER_CAP_FLAGS_CAN_POINT_LOCATION_LOCAL"], tvbrange, value)
    tree:add_le(f[name .. "_flagGIMBAL_MANAGER_CAP_FLAGS_CAN_POINT_LOCATION_GLOBAL"], tvbrange, value)
end
-- dissect flag field
function dissect_flags_GIMBAL_DEVICE_FLAGS(tree, name, tvbrange, value)
    tree:add_le(f[name .. "_flagGIMBAL_DEVICE_FLAGS_RETRACT"], tvbrange, value)
    tree:add_le(f[name .. "_flagGIMBAL_DEVICE_FLAGS_NEUTRAL"], tvbrange, value)
    tree:add_le(f[name .. "_flagGIMBAL_DEVICE_FLAGS_ROLL_LOCK"], tvbrange, value)
    tree:add_le(f[name .. "_flagGIMBAL_DEVICE_FLAGS_PITCH_LOCK"], tvbrange, value)
    tree:add_le(f[name .. "_flagGIMBAL_DEVICE_FLAGS_YAW_LOCK"], tvbrange, value)
    tree:add_le(f[name .. "_flagGIMBAL_DEVICE_FLAGS_YAW_IN_VEHICLE_FRAME"], tvbrange, value)
    tree:add_le(f[name .. "_flagGIMBAL_DEVICE_FLAGS_YAW_IN_EARTH_FRAME"], tvbrange, value)
    tree:add_le(f[name .. "_flagGIMBAL_DEVICE_FLAGS_ACCEPTS_YAW_IN_EARTH_FRAME"], tvbrange, value)
    tree:add_le(f[name .. "_flagGIMBAL_DEVICE_FLAGS_RC_EXCLUSIVE"], tvbrange, value)
    tree:add_le(f[name .. "_flagGIMBAL_DEVICE_FLAGS_RC_MIXED"], tvbrange, value)
end
-- dissect flag field
function dissect_flags_GIMBAL_MANAGER_FLAGS(tree, name, tvbrange, value)
    tree:add_le(f[name .. "_flagGIMBAL_MANAGER_FLAGS_RETRACT"], tvbrange, value)
    tree:add_le(f[name .. "_flagGIMBAL_MANAGER_FLAGS_NEUTRAL"], tvbrange, value)
    tree:add_le(f[name .. "_flagGIMBAL_MANAGER_FLAGS_ROLL_LOCK"], tvbrange, value)
    tree:add_le(f[name .. "_flagGIMBAL_MANAGER_FLAGS_PITCH_LOCK"], tvbrange, value)
    tree:add_le(f[name .. "_flagGIMBAL_MANAGER_FLAGS_YAW_LOCK"], tvbrange, value)
    tree:add_le(f[name .. "_flagGIMBAL_MANAGER_FLAGS_YAW_IN_VEHICLE_FRAME"], tvbrange, value)
    tree:add_le(f[name .. "_flagGIMBAL_MANAGER_FLAGS_YAW_IN_EARTH_FRAME"], tvbrange, value)
    tree:add_le(f[name .. "_flagGIMBAL_MANAGER_FLAGS_ACCEPTS_YAW_IN_EARTH_FRAME"], tvbrange, value)
    tree:add_le(f[name .. "_flagGIMBAL_MANAGER_FLAGS_RC_EXCLUSIVE"], tvbrange, value)
    tree:add_le(f[name .. "_flagGIMBAL_MANAGER_FLAGS_RC_MIXED"], tvbrange, value)
end
-- dissect flag field
function dissect_flags_GIMBAL_DEVICE_ERROR_FLAGS(tree, name, tvbrange, value)
    tree:add_le(f[name .. "_flagGIMBAL_DEVICE_ERROR_FLAGS_AT_ROLL_LIMIT"], tvbrange, value)
    tree:add_le(f[name .. "_flagGIMBAL_DEVICE_ERROR_FLAGS_AT_PITCH_LIMIT"], tvbrange, value)
    tree:add_le(f[name .. "_flagGIMBAL_DEVICE_ERROR_FLAGS_AT_YAW_LIMIT"], tvbrange, value)
    tree:add_le(f[name .. "_flagGIMBAL_DEVICE_ERROR_FLAGS_ENCODER_ERROR"], tvbrange, value)
    tree:add_le(f[name .. "_flagGIMBAL_DEVICE_ERROR_FLAGS_POWER_ERROR"], tvbrange, value)
    tree:add_le(f[name .. "_flagGIMBAL_DEVICE_ERROR_FLAGS_MOTOR_ERROR"], tvbrange, value)
    tree:add_le(f[name .. "_flagGIMBAL_DEVICE_ERROR_FLAGS_SOFTWARE_ERROR"], tvbrange, value)
    tree:add_le(f[name .. "_flagGIMBAL_DEVICE_ERROR_FLAGS_COMMS_ERROR"], tvbrange, value)
    tree:add_le(f[name .. "_flagGIMBAL_DEVICE_ERROR_FLAGS_CALIBRATION_RUNNING"], tvbrange, value)
    tree:add_le(f[name .. "_flagGIMBAL_DEVICE_ERROR_FLAGS_NO_MANAGER"], tvbrange, value)
end
-- dissect flag field
function dissect_flags_ESTIMATOR_STATUS_FLAGS(tree, name, tvbrange, value)
    tree:add_le(f[name .. "_flagESTIMATOR_ATTITUDE"], tvbrange, value)
    tree:add_le(f[name .. "_flagESTIMATOR_VELOCITY_HORIZ"], tvbrange, value)
    tree:add_le(f[name .. "_flagESTIMATOR_VELOCITY_VERT"], tvbrange, value)
    tree:add_le(f[name .. "_flagESTIMATOR_POS_HORIZ_REL"], tvbrange, value)
    tree:add_le(f[name .. "_flagESTIMATOR_POS_HORIZ_ABS"], tvbrange, value)
    tree:add_le(f[name .. "_flagESTIMATOR_POS_VERT_ABS"], tvbrange, value)
    tree:add_le(f[name .. "_flagESTIMATOR_POS_VERT_AGL"], tvbrange, value)
    tree:add_le(f[name .. "_flagESTIMATOR_CONST_POS_MODE"], tvbrange, value)
    tree:add_le(f[name .. "_flagESTIMATOR_PRED_POS_HORIZ_REL"], tvbrange, value)
    tree:add_le(f[name .. "_flagESTIMATOR_PRED_POS_HORIZ_ABS"], tvbrange, value)
    tree:add_le(f[name .. "_flagESTIMATOR_GPS_GLITCH"], tvbrange, value)
    tree:add_le(f[name .. "_flagESTIMATOR_ACCEL_ERROR"], tvbrange, value)
end
-- dissect flag field
function dissect_flags_POSITION_TARGET_TYPEMASK(tree, name, tvbrange, value)
    tree:add_le(f[name .. "_flagPOSITION_TARGET_TYPEMASK_X_IGNORE"], tvbrange, value)
    tree:add_le(f[name .. "_flagPOSITION_TARGET_TYPEMASK_Y_IGNORE"], tvbrange, value)
    tree:add_le(f[name .. "_flagPOSITION_TARGET_TYPEMASK_Z_IGNORE"], tvbrange, value)
    tree:add_le(f[name .. "_flagPOSITION_TARGET_TYPEMASK_VX_IGNORE"], tvbrange, value)
    tree:add_le(f[name .. "_flagPOSITION_TARGET_TYPEMASK_VY_IGNORE"], tvbrange, value)
    tree:add_le(f[name .. "_flagPOSITION_TARGET_TYPEMASK_VZ_IGNORE"], tvbrange, value)
    tree:add_le(f[name .. "_flagPOSITION_TARGET_TYPEMASK_AX_IGNORE"], tvbrange, value)
    tree:add_le(f[name .. "_flagPOSITION_TARGET_TYPEMASK_AY_IGNORE"], tvbrange, value)
    tree:add_le(f[name .. "_flagPOSITION_TARGET_TYPEMASK_AZ_IGNORE"], tvbrange, value)
    tree:add_le(f[name .. "_flagPOSITION_TARGET_TYPEMASK_FORCE_SET"], tvbrange, value)
    tree:add_le(f[name .. "_flagPOSITION_TARGET_TYPEMASK_YAW_IGNORE"], tvbrange, value)
    tree:add_le(f[name .. "_flagPOSITION_TARGET_TYPEMASK_YAW_RATE_IGNORE"], tvbrange, value)
end
-- dissect flag field
function dissect_flags_COMPUTER_STATUS_FLAGS(tree, name, tvbrange, value)
    tree:add_le(f[name .. "_flagCOMPUTER_STATUS_FLAGS_UNDER_VOLTAGE"], tvbrange, value)
    tree:add_le(f[name .. "_flagCOMPUTER_STATUS_FLAGS_CPU_THROTTLE"], tvbrange, value)
    tree:add_le(f[name .. "_flagCOMPUTER_STATUS_FLAGS_THERMAL_THROTTLE"], tvbrange, value)
    tree:add_le(f[name .. "_flagCOMPUTER_STATUS_FLAGS_DISK_FULL"], tvbrange, value)
end
-- dissect payload of message type ROSS_INFORMATION
function payload_fns.payload_54000(buffer, tree, msgid, offset, limit, pinfo)
    local padded, field_offset, value, subtree, tvbrange
    if (offset + 83 > limit) then
        padded = buffer(0, limit):bytes()
        padded:set_size(offset + 83)
        padded = padded:tvb("Untruncated payload")
    else
        padded = buffer
    end
    tvbrange = padded(offset + 0, 8)
    subtree = tree:add_le(f.ROSS_INFORMATION_time_usec, tvbrange)
    value = tvbrange:le_uint64()
    subtree:append_text(time_usec_decode(value))
    tvbrange = padded(offset + 40, 2)
    subtree = tree:add_le(f.ROSS_INFORMATION_dialect_version, tvbrange)
    tvbrange = padded(offset + 8, 4)
    subtree = tree:add_le(f.ROSS_INFORMATION_spacing, tvbrange)
    tvbrange = padded(offset + 12, 4)
    subtree = tree:add_le(f.ROSS_INFORMATION_speed_of_sound, tvbrange)
    tvbrange = padded(offset + 16, 4)
    subtree = tree:add_le(f.ROSS_INFORMATION_axis_offset, tvbrange)
    value = tvbrange:le_float()
    subtree:append_text(string.format(" (%g deg)",value*180/math.pi))
    tvbrange = padded(offset + 20, 4)
    subtree = tree:add_le(f.ROSS_INFORMATION_joint_min, tvbrange)
    value = tvbrange:le_float()
    subtree:append_text(string.format(" (%g deg)",value*180/math.pi))
    tvbrange = padded(offset + 24, 4)
    subtree = tree:add_le(f.ROSS_INFORMATION_joint_max, tvbrange)
    value = tvbrange:le_float()
    subtree:append_text(string.format(" (%g deg)",value*180/math.pi))
    tvbrange = padded(offset + 28, 4)
    subtree = tree:add_le(f.ROSS_INFORMATION_joint_rate_max, tvbrange)
    value = tvbrange:le_float()
    subtree:append_text(string.format(" (%g deg/s)",value*180/math.pi))
    tvbrange = padded(offset + 32, 4)
    subtree = tree:add_le(f.ROSS_INFORMATION_orientation_time, tvbrange)
    tvbrange = padded(offset + 36, 4)
    subtree = tree:add_le(f.ROSS_INFORMATION_sample_rate, tvbrange)
    tvbrange = padded(offset + 42, 1)
    subtree = tree:add_le(f.ROSS_INFORMATION_k_max, tvbrange)
    tvbrange = padded(offset + 43, 24)
    subtree = tree:add_le(f.ROSS_INFORMATION_software_version, tvbrange)
    tvbrange = padded(offset + 67, 16)
    subtree = tree:add_le(f.ROSS_INFORMATION_actuator, tvbrange)
end
-- dissect payload of message type ROSS_STATUS
function payload_fns.payload_54001(buffer, tree, msgid, offset, limit, pinfo)
    local padded, field_offset, value, subtree, tvbrange
    if (offset + 50 > limit) then
        padded = buffer(0, limit):bytes()
        padded:set_size(offset + 50)
        padded = padded:tvb("Untruncated payload")
    else
        padded = buffer
    end
    tvbrange = padded(offset + 0, 8)
    subtree = tree:add_le(f.ROSS_STATUS_time_usec, tvbrange)
    value = tvbrange:le_uint64()
    subtree:append_text(time_usec_decode(value))
    tvbrange = padded(offset + 8, 4)
    subtree = tree:add_le(f.ROSS_STATUS_mission_time, tvbrange)
    tvbrange = padded(offset + 42, 1)
    subtree = tree:add_le(f.ROSS_STATUS_state, tvbrange)
    tvbrange = padded(offset + 43, 1)
    subtree = tree:add_le(f.ROSS_STATUS_outcome, tvbrange)
    tvbrange = padded(offset + 44, 1)
    subtree = tree:add_le(f.ROSS_STATUS_frame, tvbrange)
    tvbrange = padded(offset + 45, 1)
    subtree = tree:add_le(f.ROSS_STATUS_flags, tvbrange)
    value = tvbrange:le_uint()
    dissect_flags_ROSS_STATUS_FLAGS(subtree, "ROSS_STATUS_flags", tvbrange, value)
    tvbrange = padded(offset + 40, 2)
    subtree = tree:add_le(f.ROSS_STATUS_actuator_flags, tvbrange)
    value = tvbrange:le_uint()
    dissect_flags_ROSS_ACTUATOR_FLAGS(subtree, "ROSS_STATUS_actuator_flags", tvbrange, value)
    tvbrange = padded(offset + 12, 4)
    subtree = tree:add_le(f.ROSS_STATUS_heading, tvbrange)
    value = tvbrange:le_float()
    subtree:append_text(string.format(" (%g deg)",value*180/math.pi))
    tvbrange = padded(offset + 16, 4)
    subtree = tree:add_le(f.ROSS_STATUS_heading_goal, tvbrange)
    value = tvbrange:le_float()
    subtree:append_text(string.format(" (%g deg)",value*180/math.pi))
    tvbrange = padded(offset + 20, 4)
    subtree = tree:add_le(f.ROSS_STATUS_joint, tvbrange)
    value = tvbrange:le_float()
    subtree:append_text(string.format(" (%g deg)",value*180/math.pi))
    tvbrange = padded(offset + 24, 4)
    subtree = tree:add_le(f.ROSS_STATUS_joint_rate, tvbrange)
    value = tvbrange:le_float()
    subtree:append_text(string.format(" (%g deg/s)",value*180/math.pi))
    tvbrange = padded(offset + 28, 4)
    subtree = tree:add_le(f.ROSS_STATUS_mount_yaw, tvbrange)
    value = tvbrange:le_float()
    subtree:append_text(string.format(" (%g deg)",value*180/math.pi))
    tvbrange = padded(offset + 32, 4)
    subtree = tree:add_le(f.ROSS_STATUS_score, tvbrange)
    tvbrange = padded(offset + 36, 4)
    subtree = tree:add_le(f.ROSS_STATUS_criterion, tvbrange)
    tvbrange = padded(offset + 46, 1)
    subtree = tree:add_le(f.ROSS_STATUS_rotation, tvbrange)
    tvbrange = padded(offset + 47, 1)
    subtree = tree:add_le(f.ROSS_STATUS_rotation_max, tvbrange)
    tvbrange = padded(offset + 48, 1)
    subtree = tree:add_le(f.ROSS_STATUS_k, tvbrange)
    tvbrange = padded(offset + 49, 1)
    subtree = tree:add_le(f.ROSS_STATUS_target, tvbrange)
end
-- dissect payload of message type ROSS_SOURCE
function payload_fns.payload_54002(buffer, tree, msgid, offset, limit, pinfo)
    local padded, field_offset, value, subtree, tvbrange
    if (offset + 50 > limit) then
        padded = buffer(0, limit):bytes()
        padded:set_size(offset + 50)
        padded = padded:tvb("Untruncated payload")
    else
        padded = buffer
    end
    tvbrange = padded(offset + 0, 8)
    subtree = tree:add_le(f.ROSS_SOURCE_time_usec, tvbrange)
    value = tvbrange:le_uint64()
    subtree:append_text(time_usec_decode(value))
    tvbrange = padded(offset + 8, 4)
    subtree = tree:add_le(f.ROSS_SOURCE_azimuth, tvbrange)
    value = tvbrange:le_float()
    subtree:append_text(string.format(" (%g deg)",value*180/math.pi))
    tvbrange = padded(offset + 12, 4)
    subtree = tree:add_le(f.ROSS_SOURCE_azimuth_mirror, tvbrange)
    value = tvbrange:le_float()
    subtree:append_text(string.format(" (%g deg)",value*180/math.pi))
    tvbrange = padded(offset + 16, 4)
    subtree = tree:add_le(f.ROSS_SOURCE_azimuth_sigma, tvbrange)
    value = tvbrange:le_float()
    subtree:append_text(string.format(" (%g deg)",value*180/math.pi))
    tvbrange = padded(offset + 20, 4)
    subtree = tree:add_le(f.ROSS_SOURCE_elevation, tvbrange)
    value = tvbrange:le_float()
    subtree:append_text(string.format(" (%g deg)",value*180/math.pi))
    tvbrange = padded(offset + 24, 4)
    subtree = tree:add_le(f.ROSS_SOURCE_confidence, tvbrange)
    tvbrange = padded(offset + 28, 4)
    subtree = tree:add_le(f.ROSS_SOURCE_weight, tvbrange)
    tvbrange = padded(offset + 32, 4)
    subtree = tree:add_le(f.ROSS_SOURCE_score, tvbrange)
    tvbrange = padded(offset + 36, 2)
    subtree = tree:add_le(f.ROSS_SOURCE_estimate, tvbrange)
    tvbrange = padded(offset + 38, 1)
    subtree = tree:add_le(f.ROSS_SOURCE_source, tvbrange)
    tvbrange = padded(offset + 39, 1)
    subtree = tree:add_le(f.ROSS_SOURCE_count, tvbrange)
    tvbrange = padded(offset + 40, 1)
    subtree = tree:add_le(f.ROSS_SOURCE_frame, tvbrange)
    tvbrange = padded(offset + 41, 1)
    subtree = tree:add_le(f.ROSS_SOURCE_flags, tvbrange)
    value = tvbrange:le_uint()
    dissect_flags_ROSS_SOURCE_FLAGS(subtree, "ROSS_SOURCE_flags", tvbrange, value)
    tvbrange = padded(offset + 42, 4)
    subtree = tree:add_le(f.ROSS_SOURCE_azimuth_rate, tvbrange)
    value = tvbrange:le_float()
    subtree:append_text(string.format(" (%g deg/s)",value*180/math.pi))
    tvbrange = padded(offset + 46, 4)
    subtree = tree:add_le(f.ROSS_SOURCE_age, tvbrange)
end
-- dissect payload of message type ROSS_ALIGNMENT
function payload_fns.payload_54003(buffer, tree, msgid, offset, limit, pinfo)
    local padded, field_offset, value, subtree, tvbrange
    if (offset + 36 > limit) then
        padded = buffer(0, limit):bytes()
        padded:set_size(offset + 36)
        padded = padded:tvb("Untruncated payload")
    else
        padded = buffer
    end
    tvbrange = padded(offset + 0, 8)
    subtree = tree:add_le(f.ROSS_ALIGNMENT_time_usec, tvbrange)
    value = tvbrange:le_uint64()
    subtree:append_text(time_usec_decode(value))
    tvbrange = padded(offset + 8, 4)
    subtree = tree:add_le(f.ROSS_ALIGNMENT_aliased, tvbrange)
    tvbrange = padded(offset + 12, 4)
    subtree = tree:add_le(f.ROSS_ALIGNMENT_heading, tvbrange)
    value = tvbrange:le_float()
    subtree:append_text(string.format(" (%g deg)",value*180/math.pi))
    tvbrange = padded(offset + 16, 4)
    subtree = tree:add_le(f.ROSS_ALIGNMENT_joint, tvbrange)
    value = tvbrange:le_float()
    subtree:append_text(string.format(" (%g deg)",value*180/math.pi))
    tvbrange = padded(offset + 20, 4)
    subtree = tree:add_le(f.ROSS_ALIGNMENT_isolation, tvbrange)
    value = tvbrange:le_float()
    subtree:append_text(time_usec_decode(value))
    tvbrange = padded(offset + 24, 2)
    subtree = tree:add_le(f.ROSS_ALIGNMENT_plan, tvbrange)
    tvbrange = padded(offset + 26, 1)
    subtree = tree:add_le(f.ROSS_ALIGNMENT_candidate, tvbrange)
    tvbrange = padded(offset + 27, 1)
    subtree = tree:add_le(f.ROSS_ALIGNMENT_count, tvbrange)
    tvbrange = padded(offset + 28, 1)
    subtree = tree:add_le(f.ROSS_ALIGNMENT_source, tvbrange)
    tvbrange = padded(offset + 29, 1)
    subtree = tree:add_le(f.ROSS_ALIGNMENT_rule, tvbrange)
    tvbrange = padded(offset + 30, 1)
    subtree = tree:add_le(f.ROSS_ALIGNMENT_state, tvbrange)
    tvbrange = padded(offset + 31, 1)
    subtree = tree:add_le(f.ROSS_ALIGNMENT_frame, tvbrange)
    tvbrange = padded(offset + 32, 4)
    subtree = tree:add_le(f.ROSS_ALIGNMENT_gain, tvbrange)
end
-- dissect payload of message type ROSS_SEPARATION
function payload_fns.payload_54004(buffer, tree, msgid, offset, limit, pinfo)
    local padded, field_offset, value, subtree, tvbrange
    if (offset + 55 > limit) then
        padded = buffer(0, limit):bytes()
        padded:set_size(offset + 55)
        padded = padded:tvb("Untruncated payload")
    else
        padded = buffer
    end
    tvbrange = padded(offset + 0, 8)
    subtree = tree:add_le(f.ROSS_SEPARATION_time_usec, tvbrange)
    value = tvbrange:le_uint64()
    subtree:append_text(time_usec_decode(value))
    tvbrange = padded(offset + 8, 4)
    subtree = tree:add_le(f.ROSS_SEPARATION_members, tvbrange)
    tvbrange = padded(offset + 12, 4)
    subtree = tree:add_le(f.ROSS_SEPARATION_heading, tvbrange)
    value = tvbrange:le_float()
    subtree:append_text(string.format(" (%g deg)",value*180/math.pi))
    tvbrange = padded(offset + 16, 4)
    subtree = tree:add_le(f.ROSS_SEPARATION_score, tvbrange)
    tvbrange = padded(offset + 20, 4)
    subtree = tree:add_le(f.ROSS_SEPARATION_criterion, tvbrange)
    tvbrange = padded(offset + 24, 4)
    subtree = tree:add_le(f.ROSS_SEPARATION_si_sdr, tvbrange)
    tvbrange = padded(offset + 28, 4)
    subtree = tree:add_le(f.ROSS_SEPARATION_si_sdr_improvement, tvbrange)
    tvbrange = padded(offset + 32, 2)
    subtree = tree:add_le(f.ROSS_SEPARATION_separation, tvbrange)
    tvbrange = padded(offset + 34, 1)
    subtree = tree:add_le(f.ROSS_SEPARATION_group, tvbrange)
    tvbrange = padded(offset + 35, 1)
    subtree = tree:add_le(f.ROSS_SEPARATION_count, tvbrange)
    tvbrange = padded(offset + 36, 1)
    subtree = tree:add_le(f.ROSS_SEPARATION_phase, tvbrange)
    tvbrange = padded(offset + 37, 1)
    subtree = tree:add_le(f.ROSS_SEPARATION_frame, tvbrange)
    tvbrange = padded(offset + 38, 1)
    subtree = tree:add_le(f.ROSS_SEPARATION_flags, tvbrange)
    value = tvbrange:le_uint()
    dissect_flags_ROSS_GROUP_FLAGS(subtree, "ROSS_SEPARATION_flags", tvbrange, value)
    tvbrange = padded(offset + 39, 16)
    subtree = tree:add_le(f.ROSS_SEPARATION_method, tvbrange)
end
-- dissect payload of message type ROSS_AUDIO
function payload_fns.payload_54005(buffer, tree, msgid, offset, limit, pinfo)
    local padded, field_offset, value, subtree, tvbrange
    if (offset + 40 > limit) then
        padded = buffer(0, limit):bytes()
        padded:set_size(offset + 40)
        padded = padded:tvb("Untruncated payload")
    else
        padded = buffer
    end
    tvbrange = padded(offset + 0, 8)
    subtree = tree:add_le(f.ROSS_AUDIO_time_usec, tvbrange)
    value = tvbrange:le_uint64()
    subtree:append_text(time_usec_decode(value))
    tvbrange = padded(offset + 8, 4)
    subtree = tree:add_le(f.ROSS_AUDIO_lost, tvbrange)
    for i = 0, 1 do
        tvbrange = padded(offset + 12 + 4 * i, 4)
        subtree = tree:add_le(f["ROSS_AUDIO_level_"..i], tvbrange)
    end
    for i = 0, 1 do
        tvbrange = padded(offset + 20 + 4 * i, 4)
        subtree = tree:add_le(f["ROSS_AUDIO_peak_"..i], tvbrange)
    end
    tvbrange = padded(offset + 28, 4)
    subtree = tree:add_le(f.ROSS_AUDIO_waiting, tvbrange)
    tvbrange = padded(offset + 32, 4)
    subtree = tree:add_le(f.ROSS_AUDIO_rate, tvbrange)
    tvbrange = padded(offset + 36, 2)
    subtree = tree:add_le(f.ROSS_AUDIO_reopened, tvbrange)
    tvbrange = padded(offset + 38, 2)
    subtree = tree:add_le(f.ROSS_AUDIO_trouble, tvbrange)
    value = tvbrange:le_uint()
    dissect_flags_ROSS_AUDIO_TROUBLE(subtree, "ROSS_AUDIO_trouble", tvbrange, value)
end
-- dissect payload of message type ROSS_RECORDING
function payload_fns.payload_54006(buffer, tree, msgid, offset, limit, pinfo)
    local padded, field_offset, value, subtree, tvbrange
    if (offset + 105 > limit) then
        padded = buffer(0, limit):bytes()
        padded:set_size(offset + 105)
        padded = padded:tvb("Untruncated payload")
    else
        padded = buffer
    end
    tvbrange = padded(offset + 0, 8)
    subtree = tree:add_le(f.ROSS_RECORDING_time_usec, tvbrange)
    value = tvbrange:le_uint64()
    subtree:append_text(time_usec_decode(value))
    tvbrange = padded(offset + 8, 4)
    subtree = tree:add_le(f.ROSS_RECORDING_duration, tvbrange)
    tvbrange = padded(offset + 12, 4)
    subtree = tree:add_le(f.ROSS_RECORDING_free, tvbrange)
    tvbrange = padded(offset + 16, 1)
    subtree = tree:add_le(f.ROSS_RECORDING_state, tvbrange)
    tvbrange = padded(offset + 17, 40)
    subtree = tree:add_le(f.ROSS_RECORDING_name, tvbrange)
    tvbrange = padded(offset + 57, 48)
    subtree = tree:add_le(f.ROSS_RECORDING_reason, tvbrange)
end
-- dissect payload of message type ROSS_DENSITY
function payload_fns.payload_54007(buffer, tree, msgid, offset, limit, pinfo)
    local padded, field_offset, value, subtree, tvbrange
    if (offset + 104 > limit) then
        padded = buffer(0, limit):bytes()
        padded:set_size(offset + 104)
        padded = padded:tvb("Untruncated payload")
    else
        padded = buffer
    end
    tvbrange = padded(offset + 0, 8)
    subtree = tree:add_le(f.ROSS_DENSITY_time_usec, tvbrange)
    value = tvbrange:le_uint64()
    subtree:append_text(time_usec_decode(value))
    tvbrange = padded(offset + 8, 4)
    subtree = tree:add_le(f.ROSS_DENSITY_heading, tvbrange)
    value = tvbrange:le_float()
    subtree:append_text(string.format(" (%g deg)",value*180/math.pi))
    tvbrange = padded(offset + 12, 4)
    subtree = tree:add_le(f.ROSS_DENSITY_itd_first, tvbrange)
    value = tvbrange:le_float()
    subtree:append_text(time_usec_decode(value))
    tvbrange = padded(offset + 16, 4)
    subtree = tree:add_le(f.ROSS_DENSITY_itd_last, tvbrange)
    value = tvbrange:le_float()
    subtree:append_text(time_usec_decode(value))
    tvbrange = padded(offset + 20, 2)
    subtree = tree:add_le(f.ROSS_DENSITY_exploration, tvbrange)
    tvbrange = padded(offset + 22, 1)
    subtree = tree:add_le(f.ROSS_DENSITY_rotation, tvbrange)
    tvbrange = padded(offset + 23, 1)
    subtree = tree:add_le(f.ROSS_DENSITY_frame, tvbrange)
    for i = 0, 79 do
        tvbrange = padded(offset + 24 + 1 * i, 1)
        subtree = tree:add_le(f["ROSS_DENSITY_density_"..i], tvbrange)
    end
end
-- dissect payload of message type ROSS_ISOLATION
function payload_fns.payload_54008(buffer, tree, msgid, offset, limit, pinfo)
    local padded, field_offset, value, subtree, tvbrange
    if (offset + 104 > limit) then
        padded = buffer(0, limit):bytes()
        padded:set_size(offset + 104)
        padded = padded:tvb("Untruncated payload")
    else
        padded = buffer
    end
    tvbrange = padded(offset + 0, 8)
    subtree = tree:add_le(f.ROSS_ISOLATION_time_usec, tvbrange)
    value = tvbrange:le_uint64()
    subtree:append_text(time_usec_decode(value))
    tvbrange = padded(offset + 8, 4)
    subtree = tree:add_le(f.ROSS_ISOLATION_heading_first, tvbrange)
    value = tvbrange:le_float()
    subtree:append_text(string.format(" (%g deg)",value*180/math.pi))
    tvbrange = padded(offset + 12, 4)
    subtree = tree:add_le(f.ROSS_ISOLATION_heading_last, tvbrange)
    value = tvbrange:le_float()
    subtree:append_text(string.format(" (%g deg)",value*180/math.pi))
    tvbrange = padded(offset + 16, 4)
    subtree = tree:add_le(f.ROSS_ISOLATION_maximum, tvbrange)
    value = tvbrange:le_float()
    subtree:append_text(time_usec_decode(value))
    tvbrange = padded(offset + 20, 2)
    subtree = tree:add_le(f.ROSS_ISOLATION_plan, tvbrange)
    tvbrange = padded(offset + 22, 1)
    subtree = tree:add_le(f.ROSS_ISOLATION_source, tvbrange)
    tvbrange = padded(offset + 23, 1)
    subtree = tree:add_le(f.ROSS_ISOLATION_frame, tvbrange)
    for i = 0, 79 do
        tvbrange = padded(offset + 24 + 1 * i, 1)
        subtree = tree:add_le(f["ROSS_ISOLATION_isolation_"..i], tvbrange)
    end
end
-- dissect payload of message type ROSS_LINK
function payload_fns.payload_54009(buffer, tree, msgid, offset, limit, pinfo)
    local padded, field_offset, value, subtree, tvbrange
    if (offset + 97 > limit) then
        padded = buffer(0, limit):bytes()
        padded:set_size(offset + 97)
        padded = padded:tvb("Untruncated payload")
    else
        padded = buffer
    end
    tvbrange = padded(offset + 0, 8)
    subtree = tree:add_le(f.ROSS_LINK_time_usec, tvbrange)
    value = tvbrange:le_uint64()
    subtree:append_text(time_usec_decode(value))
    tvbrange = padded(offset + 8, 4)
    subtree = tree:add_le(f.ROSS_LINK_sent, tvbrange)
    tvbrange = padded(offset + 12, 4)
    subtree = tree:add_le(f.ROSS_LINK_dropped, tvbrange)
    tvbrange = padded(offset + 16, 4)
    subtree = tree:add_le(f.ROSS_LINK_received, tvbrange)
    tvbrange = padded(offset + 20, 4)
    subtree = tree:add_le(f.ROSS_LINK_lost, tvbrange)
    tvbrange = padded(offset + 24, 4)
    subtree = tree:add_le(f.ROSS_LINK_bad, tvbrange)
    tvbrange = padded(offset + 28, 4)
    subtree = tree:add_le(f.ROSS_LINK_refused, tvbrange)
    tvbrange = padded(offset + 32, 2)
    subtree = tree:add_le(f.ROSS_LINK_reconnects, tvbrange)
    tvbrange = padded(offset + 34, 1)
    subtree = tree:add_le(f.ROSS_LINK_link, tvbrange)
    tvbrange = padded(offset + 35, 1)
    subtree = tree:add_le(f.ROSS_LINK_count, tvbrange)
    tvbrange = padded(offset + 36, 1)
    subtree = tree:add_le(f.ROSS_LINK_flags, tvbrange)
    value = tvbrange:le_uint()
    dissect_flags_ROSS_LINK_FLAGS(subtree, "ROSS_LINK_flags", tvbrange, value)
    tvbrange = padded(offset + 37, 60)
    subtree = tree:add_le(f.ROSS_LINK_url, tvbrange)
end
-- dissect payload of message type ROSS_STREAM
function payload_fns.payload_54010(buffer, tree, msgid, offset, limit, pinfo)
    local padded, field_offset, value, subtree, tvbrange
    if (offset + 116 > limit) then
        padded = buffer(0, limit):bytes()
        padded:set_size(offset + 116)
        padded = padded:tvb("Untruncated payload")
    else
        padded = buffer
    end
    tvbrange = padded(offset + 0, 8)
    subtree = tree:add_le(f.ROSS_STREAM_time_usec, tvbrange)
    value = tvbrange:le_uint64()
    subtree:append_text(time_usec_decode(value))
    tvbrange = padded(offset + 8, 4)
    subtree = tree:add_le(f.ROSS_STREAM_azimuth, tvbrange)
    value = tvbrange:le_float()
    subtree:append_text(string.format(" (%g deg)",value*180/math.pi))
    tvbrange = padded(offset + 12, 4)
    subtree = tree:add_le(f.ROSS_STREAM_gain, tvbrange)
    tvbrange = padded(offset + 16, 4)
    subtree = tree:add_le(f.ROSS_STREAM_rate, tvbrange)
    tvbrange = padded(offset + 20, 4)
    subtree = tree:add_le(f.ROSS_STREAM_lost, tvbrange)
    tvbrange = padded(offset + 24, 4)
    subtree = tree:add_le(f.ROSS_STREAM_packets_lost, tvbrange)
    tvbrange = padded(offset + 28, 2)
    subtree = tree:add_le(f.ROSS_STREAM_port, tvbrange)
    tvbrange = padded(offset + 30, 2)
    subtree = tree:add_le(f.ROSS_STREAM_delay, tvbrange)
    tvbrange = padded(offset + 32, 1)
    subtree = tree:add_le(f.ROSS_STREAM_number, tvbrange)
    tvbrange = padded(offset + 33, 1)
    subtree = tree:add_le(f.ROSS_STREAM_count, tvbrange)
    tvbrange = padded(offset + 34, 1)
    subtree = tree:add_le(f.ROSS_STREAM_selection, tvbrange)
    tvbrange = padded(offset + 35, 1)
    subtree = tree:add_le(f.ROSS_STREAM_source, tvbrange)
    tvbrange = padded(offset + 36, 1)
    subtree = tree:add_le(f.ROSS_STREAM_group, tvbrange)
    tvbrange = padded(offset + 37, 1)
    subtree = tree:add_le(f.ROSS_STREAM_listeners, tvbrange)
    tvbrange = padded(offset + 38, 1)
    subtree = tree:add_le(f.ROSS_STREAM_flags, tvbrange)
    value = tvbrange:le_uint()
    dissect_flags_ROSS_STREAM_FLAGS(subtree, "ROSS_STREAM_flags", tvbrange, value)
    tvbrange = padded(offset + 39, 1)
    subtree = tree:add_le(f.ROSS_STREAM_frame, tvbrange)
    tvbrange = padded(offset + 40, 1)
    subtree = tree:add_le(f.ROSS_STREAM_codec, tvbrange)
    tvbrange = padded(offset + 41, 1)
    subtree = tree:add_le(f.ROSS_STREAM_level, tvbrange)
    tvbrange = padded(offset + 42, 10)
    subtree = tree:add_le(f.ROSS_STREAM_sink, tvbrange)
    tvbrange = padded(offset + 52, 40)
    subtree = tree:add_le(f.ROSS_STREAM_address, tvbrange)
    tvbrange = padded(offset + 92, 24)
    subtree = tree:add_le(f.ROSS_STREAM_detail, tvbrange)
end
-- dissect payload of message type COMMAND_CANCEL
function payload_fns.payload_80(buffer, tree, msgid, offset, limit, pinfo)
    local padded, field_offset, value, subtree, tvbrange
    if (offset + 4 > limit) then
        padded = buffer(0, limit):bytes()
        padded:set_size(offset + 4)
        padded = padded:tvb("Untruncated payload")
    else
        padded = buffer
    end
    local cmd_id = padded(offset + 0, 2):le_uint()
    local cmd_name = enumEntryName.MAV_CMD[cmd_id]
    if cmd_name ~= nil then
        pinfo.cols.info:append(": " .. cmd_name)
    end
    tvbrange = padded(offset + 2, 1)
    subtree = tree:add_le(f.COMMAND_CANCEL_target_system, tvbrange)
    tvbrange = padded(offset + 3, 1)
    subtree = tree:add_le(f.COMMAND_CANCEL_target_component, tvbrange)
    tvbrange = padded(offset + 0, 2)
    subtree = tree:add_le(f.COMMAND_CANCEL_command, tvbrange)
end
-- dissect payload of message type TIMESYNC
function payload_fns.payload_111(buffer, tree, msgid, offset, limit, pinfo)
    local padded, field_offset, value, subtree, tvbrange
    if (offset + 18 > limit) then
        padded = buffer(0, limit):bytes()
        padded:set_size(offset + 18)
        padded = padded:tvb("Untruncated payload")
    else
        padded = buffer
    end
    tvbrange = padded(offset + 0, 8)
    subtree = tree:add_le(f.TIMESYNC_tc1, tvbrange)
    tvbrange = padded(offset + 8, 8)
    subtree = tree:add_le(f.TIMESYNC_ts1, tvbrange)
    tvbrange = padded(offset + 16, 1)
    subtree = tree:add_le(f.TIMESYNC_target_system, tvbrange)
    tvbrange = padded(offset + 17, 1)
    subtree = tree:add_le(f.TIMESYNC_target_component, tvbrange)
end
-- dissect payload of message type RPM
function payload_fns.payload_226(buffer, tree, msgid, offset, limit, pinfo)
    local padded, field_offset, value, subtree, tvbrange
    if (offset + 8 > limit) then
        padded = buffer(0, limit):bytes()
        padded:set_size(offset + 8)
        padded = padded:tvb("Untruncated payload")
    else
        padded = buffer
    end
    tvbrange = padded(offset + 0, 4)
    subtree = tree:add_le(f.RPM_rpm1, tvbrange)
    tvbrange = padded(offset + 4, 4)
    subtree = tree:add_le(f.RPM_rpm2, tvbrange)
end
-- dissect payload of message type ESC_STATUS
function payload_fns.payload_291(buffer, tree, msgid, offset, limit, pinfo)
    local padded, field_offset, value, subtree, tvbrange
    if (offset + 57 > limit) then
        padded = buffer(0, limit):bytes()
        padded:set_size(offset + 57)
        padded = padded:tvb("Untruncated payload")
    else
        padded = buffer
    end
    tvbrange = padded(offset + 56, 1)
    subtree = tree:add_le(f.ESC_STATUS_index, tvbrange)
    tvbrange = padded(offset + 0, 8)
    subtree = tree:add_le(f.ESC_STATUS_time_usec, tvbrange)
    value = tvbrange:le_uint64()
    subtree:append_text(time_usec_decode(value))
    for i = 0, 3 do
        tvbrange = padded(offset + 8 + 4 * i, 4)
        subtree = tree:add_le(f["ESC_STATUS_rpm_"..i], tvbrange)
    end
    for i = 0, 3 do
        tvbrange = padded(offset + 24 + 4 * i, 4)
        subtree = tree:add_le(f["ESC_STATUS_voltage_"..i], tvbrange)
    end
    for i = 0, 3 do
        tvbrange = padded(offset + 40 + 4 * i, 4)
        subtree = tree:add_le(f["ESC_STATUS_current_"..i], tvbrange)
    end
end
-- dissect payload of message type PROTOCOL_VERSION
function payload_fns.payload_300(buffer, tree, msgid, offset, limit, pinfo)
    local padded, field_offset, value, subtree, tvbrange
    if (offset + 22 > limit) then
        padded = buffer(0, limit):bytes()
        padded:set_size(offset + 22)
        padded = padded:tvb("Untruncated payload")
    else
        padded = buffer
    end
    tvbrange = padded(offset + 0, 2)
    subtree = tree:add_le(f.PROTOCOL_VERSION_version, tvbrange)
    tvbrange = padded(offset + 2, 2)
    subtree = tree:add_le(f.PROTOCOL_VERSION_min_version, tvbrange)
    tvbrange = padded(offset + 4, 2)
    subtree = tree:add_le(f.PROTOCOL_VERSION_max_version, tvbrange)
    for i = 0, 7 do
        tvbrange = padded(offset + 6 + 1 * i, 1)
        subtree = tree:add_le(f["PROTOCOL_VERSION_spec_version_hash_"..i], tvbrange)
    end
    for i = 0, 7 do
        tvbrange = padded(offset + 14 + 1 * i, 1)
        subtree = tree:add_le(f["PROTOCOL_VERSION_library_version_hash_"..i], tvbrange)
    end
end
-- dissect payload of message type COMPONENT_INFORMATION_BASIC
function payload_fns.payload_396(buffer, tree, msgid, offset, limit, pinfo)
    local padded, field_offset, value, subtree, tvbrange
    if (offset + 160 > limit) then
        padded = buffer(0, limit):bytes()
        padded:set_size(offset + 160)
        padded = padded:tvb("Untruncated payload")
    else
        padded = buffer
    end
    tvbrange = padded(offset + 8, 4)
    subtree = tree:add_le(f.COMPONENT_INFORMATION_BASIC_time_boot_ms, tvbrange)
    tvbrange = padded(offset + 0, 8)
    subtree = tree:add_le(f.COMPONENT_INFORMATION_BASIC_capabilities, tvbrange)
    tvbrange = padded(offset + 12, 4)
    subtree = tree:add_le(f.COMPONENT_INFORMATION_BASIC_time_manufacture_s, tvbrange)
    tvbrange = padded(offset + 16, 32)
    subtree = tree:add_le(f.COMPONENT_INFORMATION_BASIC_vendor_name, tvbrange)
    tvbrange = padded(offset + 48, 32)
    subtree = tree:add_le(f.COMPONENT_INFORMATION_BASIC_model_name, tvbrange)
    tvbrange = padded(offset + 80, 24)
    subtree = tree:add_le(f.COMPONENT_INFORMATION_BASIC_software_version, tvbrange)
    tvbrange = padded(offset + 104, 24)
    subtree = tree:add_le(f.COMPONENT_INFORMATION_BASIC_hardware_version, tvbrange)
    tvbrange = padded(offset + 128, 32)
    subtree = tree:add_le(f.COMPONENT_INFORMATION_BASIC_serial_number, tvbrange)
end
-- dissect payload of message type COMPONENT_METADATA
function payload_fns.payload_397(buffer, tree, msgid, offset, limit, pinfo)
    local padded, field_offset, value, subtree, tvbrange
    if (offset + 108 > limit) then
        padded = buffer(0, limit):bytes()
        padded:set_size(offset + 108)
        padded = padded:tvb("Untruncated payload")
    else
        padded = buffer
    end
    tvbrange = padded(offset + 0, 4)
    subtree = tree:add_le(f.COMPONENT_METADATA_time_boot_ms, tvbrange)
    tvbrange = padded(offset + 4, 4)
    subtree = tree:add_le(f.COMPONENT_METADATA_file_crc, tvbrange)
    tvbrange = padded(offset + 8, 100)
    subtree = tree:add_le(f.COMPONENT_METADATA_uri, tvbrange)
end
-- dissect payload of message type CURRENT_MODE
function payload_fns.payload_436(buffer, tree, msgid, offset, limit, pinfo)
    local padded, field_offset, value, subtree, tvbrange
    if (offset + 9 > limit) then
        padded = buffer(0, limit):bytes()
        padded:set_size(offset + 9)
        padded = padded:tvb("Untruncated payload")
    else
        padded = buffer
    end
    tvbrange = padded(offset + 8, 1)
    subtree = tree:add_le(f.CURRENT_MODE_standard_mode, tvbrange)
    tvbrange = padded(offset + 0, 4)
    subtree = tree:add_le(f.CURRENT_MODE_custom_mode, tvbrange)
    tvbrange = padded(offset + 4, 4)
    subtree = tree:add_le(f.CURRENT_MODE_intended_custom_mode, tvbrange)
end
-- dissect payload of message type ESC_TELEMETRY_1_TO_4
function payload_fns.payload_11030(buffer, tree, msgid, offset, limit, pinfo)
    local padded, field_offset, value, subtree, tvbrange
    if (offset + 44 > limit) then
        padded = buffer(0, limit):bytes()
        padded:set_size(offset + 44)
        padded = padded:tvb("Untruncated payload")
    else
        padded = buffer
    end
    for i = 0, 3 do
        tvbrange = padded(offset + 40 + 1 * i, 1)
        subtree = tree:add_le(f["ESC_TELEMETRY_1_TO_4_temperature_"..i], tvbrange)
    end
    for i = 0, 3 do
        tvbrange = padded(offset + 0 + 2 * i, 2)
        subtree = tree:add_le(f["ESC_TELEMETRY_1_TO_4_voltage_"..i], tvbrange)
    end
    for i = 0, 3 do
        tvbrange = padded(offset + 8 + 2 * i, 2)
        subtree = tree:add_le(f["ESC_TELEMETRY_1_TO_4_current_"..i], tvbrange)
    end
    for i = 0, 3 do
        tvbrange = padded(offset + 16 + 2 * i, 2)
        subtree = tree:add_le(f["ESC_TELEMETRY_1_TO_4_totalcurrent_"..i], tvbrange)
    end
    for i = 0, 3 do
        tvbrange = padded(offset + 24 + 2 * i, 2)
        subtree = tree:add_le(f["ESC_TELEMETRY_1_TO_4_rpm_"..i], tvbrange)
    end
    for i = 0, 3 do
        tvbrange = padded(offset + 32 + 2 * i, 2)
        subtree = tree:add_le(f["ESC_TELEMETRY_1_TO_4_count_"..i], tvbrange)
    end
end
-- dissect payload of message type ESC_TELEMETRY_5_TO_8
function payload_fns.payload_11031(buffer, tree, msgid, offset, limit, pinfo)
    local padded, field_offset, value, subtree, tvbrange
    if (offset + 44 > limit) then
        padded = buffer(0, limit):bytes()
        padded:set_size(offset + 44)
        padded = padded:tvb("Untruncated payload")
    else
        padded = buffer
    end
    for i = 0, 3 do
        tvbrange = padded(offset + 40 + 1 * i, 1)
        subtree = tree:add_le(f["ESC_TELEMETRY_5_TO_8_temperature_"..i], tvbrange)
    end
    for i = 0, 3 do
        tvbrange = padded(offset + 0 + 2 * i, 2)
        subtree = tree:add_le(f["ESC_TELEMETRY_5_TO_8_voltage_"..i], tvbrange)
    end
    for i = 0, 3 do
        tvbrange = padded(offset + 8 + 2 * i, 2)
        subtree = tree:add_le(f["ESC_TELEMETRY_5_TO_8_current_"..i], tvbrange)
    end
    for i = 0, 3 do
        tvbrange = padded(offset + 16 + 2 * i, 2)
        subtree = tree:add_le(f["ESC_TELEMETRY_5_TO_8_totalcurrent_"..i], tvbrange)
    end
    for i = 0, 3 do
        tvbrange = padded(offset + 24 + 2 * i, 2)
        subtree = tree:add_le(f["ESC_TELEMETRY_5_TO_8_rpm_"..i], tvbrange)
    end
    for i = 0, 3 do
        tvbrange = padded(offset + 32 + 2 * i, 2)
        subtree = tree:add_le(f["ESC_TELEMETRY_5_TO_8_count_"..i], tvbrange)
    end
end
-- dissect payload of message type ESC_TELEMETRY_9_TO_12
function payload_fns.payload_11032(buffer, tree, msgid, offset, limit, pinfo)
    local padded, field_offset, value, subtree, tvbrange
    if (offset + 44 > limit) then
        padded = buffer(0, limit):bytes()
        padded:set_size(offset + 44)
        padded = padded:tvb("Untruncated payload")
    else
        padded = buffer
    end
    for i = 0, 3 do
        tvbrange = padded(offset + 40 + 1 * i, 1)
        subtree = tree:add_le(f["ESC_TELEMETRY_9_TO_12_temperature_"..i], tvbrange)
    end
    for i = 0, 3 do
        tvbrange = padded(offset + 0 + 2 * i, 2)
        subtree = tree:add_le(f["ESC_TELEMETRY_9_TO_12_voltage_"..i], tvbrange)
    end
    for i = 0, 3 do
        tvbrange = padded(offset + 8 + 2 * i, 2)
        subtree = tree:add_le(f["ESC_TELEMETRY_9_TO_12_current_"..i], tvbrange)
    end
    for i = 0, 3 do
        tvbrange = padded(offset + 16 + 2 * i, 2)
        subtree = tree:add_le(f["ESC_TELEMETRY_9_TO_12_totalcurrent_"..i], tvbrange)
    end
    for i = 0, 3 do
        tvbrange = padded(offset + 24 + 2 * i, 2)
        subtree = tree:add_le(f["ESC_TELEMETRY_9_TO_12_rpm_"..i], tvbrange)
    end
    for i = 0, 3 do
        tvbrange = padded(offset + 32 + 2 * i, 2)
        subtree = tree:add_le(f["ESC_TELEMETRY_9_TO_12_count_"..i], tvbrange)
    end
end
-- dissect payload of message type HEARTBEAT
function payload_fns.payload_0(buffer, tree, msgid, offset, limit, pinfo)
    local padded, field_offset, value, subtree, tvbrange
    if (offset + 9 > limit) then
        padded = buffer(0, limit):bytes()
        padded:set_size(offset + 9)
        padded = padded:tvb("Untruncated payload")
    else
        padded = buffer
    end
    tvbrange = padded(offset + 4, 1)
    subtree = tree:add_le(f.HEARTBEAT_type, tvbrange)
    tvbrange = padded(offset + 5, 1)
    subtree = tree:add_le(f.HEARTBEAT_autopilot, tvbrange)
    tvbrange = padded(offset + 6, 1)
    subtree = tree:add_le(f.HEARTBEAT_base_mode, tvbrange)
    value = tvbrange:le_uint()
    dissect_flags_MAV_MODE_FLAG(subtree, "HEARTBEAT_base_mode", tvbrange, value)
    tvbrange = padded(offset + 0, 4)
    subtree = tree:add_le(f.HEARTBEAT_custom_mode, tvbrange)
    tvbrange = padded(offset + 7, 1)
    subtree = tree:add_le(f.HEARTBEAT_system_status, tvbrange)
    tvbrange = padded(offset + 8, 1)
    subtree = tree:add_le(f.HEARTBEAT_mavlink_version, tvbrange)
end
-- dissect payload of message type GLOBAL_POSITION_INT
function payload_fns.payload_33(buffer, tree, msgid, offset, limit, pinfo)
    local padded, field_offset, value, subtree, tvbrange
    if (offset + 28 > limit) then
        padded = buffer(0, limit):bytes()
        padded:set_size(offset + 28)
        padded = padded:tvb("Untruncated payload")
    else
        padded = buffer
    end
    tvbrange = padded(offset + 0, 4)
    subtree = tree:add_le(f.GLOBAL_POSITION_INT_time_boot_ms, tvbrange)
    tvbrange = padded(offset + 4, 4)
    subtree = tree:add_le(f.GLOBAL_POSITION_INT_lat, tvbrange)
    value = tvbrange:le_int()
    subtree:append_text(string.format(" (%.7f deg)",value/1E7))
    tvbrange = padded(offset + 8, 4)
    subtree = tree:add_le(f.GLOBAL_POSITION_INT_lon, tvbrange)
    value = tvbrange:le_int()
    subtree:append_text(string.format(" (%.7f deg)",value/1E7))
    tvbrange = padded(offset + 12, 4)
    subtree = tree:add_le(f.GLOBAL_POSITION_INT_alt, tvbrange)
    tvbrange = padded(offset + 16, 4)
    subtree = tree:add_le(f.GLOBAL_POSITION_INT_relative_alt, tvbrange)
    tvbrange = padded(offset + 20, 2)
    subtree = tree:add_le(f.GLOBAL_POSITION_INT_vx, tvbrange)
    tvbrange = padded(offset + 22, 2)
    subtree = tree:add_le(f.GLOBAL_POSITION_INT_vy, tvbrange)
    tvbrange = padded(offset + 24, 2)
    subtree = tree:add_le(f.GLOBAL_POSITION_INT_vz, tvbrange)
    tvbrange = padded(offset + 26, 2)
    subtree = tree:add_le(f.GLOBAL_POSITION_INT_hdg, tvbrange)
end
-- dissect payload of message type AUTOPILOT_VERSION
function payload_fns.payload_148(buffer, tree, msgid, offset, limit, pinfo)
    local padded, field_offset, value, subtree, tvbrange
    if (offset + 78 > limit) then
        padded = buffer(0, limit):bytes()
        padded:set_size(offset + 78)
        padded = padded:tvb("Untruncated payload")
    else
        padded = buffer
    end
    tvbrange = padded(offset + 0, 8)
    value = tvbrange:le_uint64()
    subtree = tree:add_le(f.AUTOPILOT_VERSION_capabilities, tvbrange, value)
    dissect_flags_MAV_PROTOCOL_CAPABILITY(subtree, "AUTOPILOT_VERSION_capabilities", tvbrange, value:tonumber())
    tvbrange = padded(offset + 16, 4)
    subtree = tree:add_le(f.AUTOPILOT_VERSION_flight_sw_version, tvbrange)
    tvbrange = padded(offset + 20, 4)
    subtree = tree:add_le(f.AUTOPILOT_VERSION_middleware_sw_version, tvbrange)
    tvbrange = padded(offset + 24, 4)
    subtree = tree:add_le(f.AUTOPILOT_VERSION_os_sw_version, tvbrange)
    tvbrange = padded(offset + 28, 4)
    subtree = tree:add_le(f.AUTOPILOT_VERSION_board_version, tvbrange)
    for i = 0, 7 do
        tvbrange = padded(offset + 36 + 1 * i, 1)
        subtree = tree:add_le(f["AUTOPILOT_VERSION_flight_custom_version_"..i], tvbrange)
    end
    for i = 0, 7 do
        tvbrange = padded(offset + 44 + 1 * i, 1)
        subtree = tree:add_le(f["AUTOPILOT_VERSION_middleware_custom_version_"..i], tvbrange)
    end
    for i = 0, 7 do
        tvbrange = padded(offset + 52 + 1 * i, 1)
        subtree = tree:add_le(f["AUTOPILOT_VERSION_os_custom_version_"..i], tvbrange)
    end
    tvbrange = padded(offset + 32, 2)
    subtree = tree:add_le(f.AUTOPILOT_VERSION_vendor_id, tvbrange)
    tvbrange = padded(offset + 34, 2)
    subtree = tree:add_le(f.AUTOPILOT_VERSION_product_id, tvbrange)
    tvbrange = padded(offset + 8, 8)
    subtree = tree:add_le(f.AUTOPILOT_VERSION_uid, tvbrange)
    for i = 0, 17 do
        tvbrange = padded(offset + 60 + 1 * i, 1)
        subtree = tree:add_le(f["AUTOPILOT_VERSION_uid2_"..i], tvbrange)
    end
end
-- dissect payload of message type SYSTEM_TIME
function payload_fns.payload_2(buffer, tree, msgid, offset, limit, pinfo)
    local padded, field_offset, value, subtree, tvbrange
    if (offset + 12 > limit) then
        padded = buffer(0, limit):bytes()
        padded:set_size(offset + 12)
        padded = padded:tvb("Untruncated payload")
    else
        padded = buffer
    end
    tvbrange = padded(offset + 0, 8)
    subtree = tree:add_le(f.SYSTEM_TIME_time_unix_usec, tvbrange)
    value = tvbrange:le_uint64()
    subtree:append_text(time_usec_decode(value))
    tvbrange = padded(offset + 8, 4)
    subtree = tree:add_le(f.SYSTEM_TIME_time_boot_ms, tvbrange)
end
-- dissect payload of message type PARAM_REQUEST_READ
function payload_fns.payload_20(buffer, tree, msgid, offset, limit, pinfo)
    local padded, field_offset, value, subtree, tvbrange
    if (offset + 20 > limit) then
        padded = buffer(0, limit):bytes()
        padded:set_size(offset + 20)
        padded = padded:tvb("Untruncated payload")
    else
        padded = buffer
    end
    tvbrange = padded(offset + 2, 1)
    subtree = tree:add_le(f.PARAM_REQUEST_READ_target_system, tvbrange)
    tvbrange = padded(offset + 3, 1)
    subtree = tree:add_le(f.PARAM_REQUEST_READ_target_component, tvbrange)
    tvbrange = padded(offset + 4, 16)
    subtree = tree:add_le(f.PARAM_REQUEST_READ_param_id, tvbrange)
    tvbrange = padded(offset + 0, 2)
    subtree = tree:add_le(f.PARAM_REQUEST_READ_param_index, tvbrange)
end
-- dissect payload of message type PARAM_REQUEST_LIST
function payload_fns.payload_21(buffer, tree, msgid, offset, limit, pinfo)
    local padded, field_offset, value, subtree, tvbrange
    if (offset + 2 > limit) then
        padded = buffer(0, limit):bytes()
        padded:set_size(offset + 2)
        padded = padded:tvb("Untruncated payload")
    else
        padded = buffer
    end
    tvbrange = padded(offset + 0, 1)
    subtree = tree:add_le(f.PARAM_REQUEST_LIST_target_system, tvbrange)
    tvbrange = padded(offset + 1, 1)
    subtree = tree:add_le(f.PARAM_REQUEST_LIST_target_component, tvbrange)
end
-- dissect payload of message type PARAM_VALUE
function payload_fns.payload_22(buffer, tree, msgid, offset, limit, pinfo)
    local padded, field_offset, value, subtree, tvbrange
    if (offset + 25 > limit) then
        padded = buffer(0, limit):bytes()
        padded:set_size(offset + 25)
        padded = padded:tvb("Untruncated payload")
    else
        padded = buffer
    end
    tvbrange = padded(offset + 8, 16)
    subtree = tree:add_le(f.PARAM_VALUE_param_id, tvbrange)
    tvbrange = padded(offset + 0, 4)
    subtree = tree:add_le(f.PARAM_VALUE_param_value, tvbrange)
    tvbrange = padded(offset + 24, 1)
    subtree = tree:add_le(f.PARAM_VALUE_param_type, tvbrange)
    tvbrange = padded(offset + 4, 2)
    subtree = tree:add_le(f.PARAM_VALUE_param_count, tvbrange)
    tvbrange = padded(offset + 6, 2)
    subtree = tree:add_le(f.PARAM_VALUE_param_index, tvbrange)
end
-- dissect payload of message type PARAM_SET
function payload_fns.payload_23(buffer, tree, msgid, offset, limit, pinfo)
    local padded, field_offset, value, subtree, tvbrange
    if (offset + 23 > limit) then
        padded = buffer(0, limit):bytes()
        padded:set_size(offset + 23)
        padded = padded:tvb("Untruncated payload")
    else
        padded = buffer
    end
    tvbrange = padded(offset + 4, 1)
    subtree = tree:add_le(f.PARAM_SET_target_system, tvbrange)
    tvbrange = padded(offset + 5, 1)
    subtree = tree:add_le(f.PARAM_SET_target_component, tvbrange)
    tvbrange = padded(offset + 6, 16)
    subtree = tree:add_le(f.PARAM_SET_param_id, tvbrange)
    tvbrange = padded(offset + 0, 4)
    subtree = tree:add_le(f.PARAM_SET_param_value, tvbrange)
    tvbrange = padded(offset + 22, 1)
    subtree = tree:add_le(f.PARAM_SET_param_type, tvbrange)
end
-- dissect payload of message type ATTITUDE
function payload_fns.payload_30(buffer, tree, msgid, offset, limit, pinfo)
    local padded, field_offset, value, subtree, tvbrange
    if (offset + 28 > limit) then
        padded = buffer(0, limit):bytes()
        padded:set_size(offset + 28)
        padded = padded:tvb("Untruncated payload")
    else
        padded = buffer
    end
    tvbrange = padded(offset + 0, 4)
    subtree = tree:add_le(f.ATTITUDE_time_boot_ms, tvbrange)
    tvbrange = padded(offset + 4, 4)
    subtree = tree:add_le(f.ATTITUDE_roll, tvbrange)
    value = tvbrange:le_float()
    subtree:append_text(string.format(" (%g deg)",value*180/math.pi))
    tvbrange = padded(offset + 8, 4)
    subtree = tree:add_le(f.ATTITUDE_pitch, tvbrange)
    value = tvbrange:le_float()
    subtree:append_text(string.format(" (%g deg)",value*180/math.pi))
    tvbrange = padded(offset + 12, 4)
    subtree = tree:add_le(f.ATTITUDE_yaw, tvbrange)
    value = tvbrange:le_float()
    subtree:append_text(string.format(" (%g deg)",value*180/math.pi))
    tvbrange = padded(offset + 16, 4)
    subtree = tree:add_le(f.ATTITUDE_rollspeed, tvbrange)
    value = tvbrange:le_float()
    subtree:append_text(string.format(" (%g deg/s)",value*180/math.pi))
    tvbrange = padded(offset + 20, 4)
    subtree = tree:add_le(f.ATTITUDE_pitchspeed, tvbrange)
    value = tvbrange:le_float()
    subtree:append_text(string.format(" (%g deg/s)",value*180/math.pi))
    tvbrange = padded(offset + 24, 4)
    subtree = tree:add_le(f.ATTITUDE_yawspeed, tvbrange)
    value = tvbrange:le_float()
    subtree:append_text(string.format(" (%g deg/s)",value*180/math.pi))
end
-- dissect payload of message type ATTITUDE_QUATERNION
function payload_fns.payload_31(buffer, tree, msgid, offset, limit, pinfo)
    local padded, field_offset, value, subtree, tvbrange
    if (offset + 48 > limit) then
        padded = buffer(0, limit):bytes()
        padded:set_size(offset + 48)
        padded = padded:tvb("Untruncated payload")
    else
        padded = buffer
    end
    tvbrange = padded(offset + 0, 4)
    subtree = tree:add_le(f.ATTITUDE_QUATERNION_time_boot_ms, tvbrange)
    tvbrange = padded(offset + 4, 4)
    subtree = tree:add_le(f.ATTITUDE_QUATERNION_q1, tvbrange)
    tvbrange = padded(offset + 8, 4)
    subtree = tree:add_le(f.ATTITUDE_QUATERNION_q2, tvbrange)
    tvbrange = padded(offset + 12, 4)
    subtree = tree:add_le(f.ATTITUDE_QUATERNION_q3, tvbrange)
    tvbrange = padded(offset + 16, 4)
    subtree = tree:add_le(f.ATTITUDE_QUATERNION_q4, tvbrange)
    tvbrange = padded(offset + 20, 4)
    subtree = tree:add_le(f.ATTITUDE_QUATERNION_rollspeed, tvbrange)
    value = tvbrange:le_float()
    subtree:append_text(string.format(" (%g deg/s)",value*180/math.pi))
    tvbrange = padded(offset + 24, 4)
    subtree = tree:add_le(f.ATTITUDE_QUATERNION_pitchspeed, tvbrange)
    value = tvbrange:le_float()
    subtree:append_text(string.format(" (%g deg/s)",value*180/math.pi))
    tvbrange = padded(offset + 28, 4)
    subtree = tree:add_le(f.ATTITUDE_QUATERNION_yawspeed, tvbrange)
    value = tvbrange:le_float()
    subtree:append_text(string.format(" (%g deg/s)",value*180/math.pi))
    for i = 0, 3 do
        tvbrange = padded(offset + 32 + 4 * i, 4)
        subtree = tree:add_le(f["ATTITUDE_QUATERNION_repr_offset_q_"..i], tvbrange)
    end
end
-- dissect payload of message type LOCAL_POSITION_NED
function payload_fns.payload_32(buffer, tree, msgid, offset, limit, pinfo)
    local padded, field_offset, value, subtree, tvbrange
    if (offset + 28 > limit) then
        padded = buffer(0, limit):bytes()
        padded:set_size(offset + 28)
        padded = padded:tvb("Untruncated payload")
    else
        padded = buffer
    end
    tvbrange = padded(offset + 0, 4)
    subtree = tree:add_le(f.LOCAL_POSITION_NED_time_boot_ms, tvbrange)
    tvbrange = padded(offset + 4, 4)
    subtree = tree:add_le(f.LOCAL_POSITION_NED_x, tvbrange)
    tvbrange = padded(offset + 8, 4)
    subtree = tree:add_le(f.LOCAL_POSITION_NED_y, tvbrange)
    tvbrange = padded(offset + 12, 4)
    subtree = tree:add_le(f.LOCAL_POSITION_NED_z, tvbrange)
    tvbrange = padded(offset + 16, 4)
    subtree = tree:add_le(f.LOCAL_POSITION_NED_vx, tvbrange)
    tvbrange = padded(offset + 20, 4)
    subtree = tree:add_le(f.LOCAL_POSITION_NED_vy, tvbrange)
    tvbrange = padded(offset + 24, 4)
    subtree = tree:add_le(f.LOCAL_POSITION_NED_vz, tvbrange)
end
-- dissect payload of message type RC_CHANNELS
function payload_fns.payload_65(buffer, tree, msgid, offset, limit, pinfo)
    local padded, field_offset, value, subtree, tvbrange
    if (offset + 42 > limit) then
        padded = buffer(0, limit):bytes()
        padded:set_size(offset + 42)
        padded = padded:tvb("Untruncated payload")
    else
        padded = buffer
    end
    tvbrange = padded(offset + 0, 4)
    subtree = tree:add_le(f.RC_CHANNELS_time_boot_ms, tvbrange)
    tvbrange = padded(offset + 40, 1)
    subtree = tree:add_le(f.RC_CHANNELS_chancount, tvbrange)
    tvbrange = padded(offset + 4, 2)
    subtree = tree:add_le(f.RC_CHANNELS_chan1_raw, tvbrange)
    value = tvbrange:le_uint()
    subtree:append_text(time_usec_decode(value))
    tvbrange = padded(offset + 6, 2)
    subtree = tree:add_le(f.RC_CHANNELS_chan2_raw, tvbrange)
    value = tvbrange:le_uint()
    subtree:append_text(time_usec_decode(value))
    tvbrange = padded(offset + 8, 2)
    subtree = tree:add_le(f.RC_CHANNELS_chan3_raw, tvbrange)
    value = tvbrange:le_uint()
    subtree:append_text(time_usec_decode(value))
    tvbrange = padded(offset + 10, 2)
    subtree = tree:add_le(f.RC_CHANNELS_chan4_raw, tvbrange)
    value = tvbrange:le_uint()
    subtree:append_text(time_usec_decode(value))
    tvbrange = padded(offset + 12, 2)
    subtree = tree:add_le(f.RC_CHANNELS_chan5_raw, tvbrange)
    value = tvbrange:le_uint()
    subtree:append_text(time_usec_decode(value))
    tvbrange = padded(offset + 14, 2)
    subtree = tree:add_le(f.RC_CHANNELS_chan6_raw, tvbrange)
    value = tvbrange:le_uint()
    subtree:append_text(time_usec_decode(value))
    tvbrange = padded(offset + 16, 2)
    subtree = tree:add_le(f.RC_CHANNELS_chan7_raw, tvbrange)
    value = tvbrange:le_uint()
    subtree:append_text(time_usec_decode(value))
    tvbrange = padded(offset + 18, 2)
    subtree = tree:add_le(f.RC_CHANNELS_chan8_raw, tvbrange)
    value = tvbrange:le_uint()
    subtree:append_text(time_usec_decode(value))
    tvbrange = padded(offset + 20, 2)
    subtree = tree:add_le(f.RC_CHANNELS_chan9_raw, tvbrange)
    value = tvbrange:le_uint()
    subtree:append_text(time_usec_decode(value))
    tvbrange = padded(offset + 22, 2)
    subtree = tree:add_le(f.RC_CHANNELS_chan10_raw, tvbrange)
    value = tvbrange:le_uint()
    subtree:append_text(time_usec_decode(value))
    tvbrange = padded(offset + 24, 2)
    subtree = tree:add_le(f.RC_CHANNELS_chan11_raw, tvbrange)
    value = tvbrange:le_uint()
    subtree:append_text(time_usec_decode(value))
    tvbrange = padded(offset + 26, 2)
    subtree = tree:add_le(f.RC_CHANNELS_chan12_raw, tvbrange)
    value = tvbrange:le_uint()
    subtree:append_text(time_usec_decode(value))
    tvbrange = padded(offset + 28, 2)
    subtree = tree:add_le(f.RC_CHANNELS_chan13_raw, tvbrange)
    value = tvbrange:le_uint()
    subtree:append_text(time_usec_decode(value))
    tvbrange = padded(offset + 30, 2)
    subtree = tree:add_le(f.RC_CHANNELS_chan14_raw, tvbrange)
    value = tvbrange:le_uint()
    subtree:append_text(time_usec_decode(value))
    tvbrange = padded(offset + 32, 2)
    subtree = tree:add_le(f.RC_CHANNELS_chan15_raw, tvbrange)
    value = tvbrange:le_uint()
    subtree:append_text(time_usec_decode(value))
    tvbrange = padded(offset + 34, 2)
    subtree = tree:add_le(f.RC_CHANNELS_chan16_raw, tvbrange)
    value = tvbrange:le_uint()
    subtree:append_text(time_usec_decode(value))
    tvbrange = padded(offset + 36, 2)
    subtree = tree:add_le(f.RC_CHANNELS_chan17_raw, tvbrange)
    value = tvbrange:le_uint()
    subtree:append_text(time_usec_decode(value))
    tvbrange = padded(offset + 38, 2)
    subtree = tree:add_le(f.RC_CHANNELS_chan18_raw, tvbrange)
    value = tvbrange:le_uint()
    subtree:append_text(time_usec_decode(value))
    tvbrange = padded(offset + 41, 1)
    subtree = tree:add_le(f.RC_CHANNELS_rssi, tvbrange)
end
-- dissect payload of message type MANUAL_CONTROL
function payload_fns.payload_69(buffer, tree, msgid, offset, limit, pinfo)
    local padded, field_offset, value, subtree, tvbrange
    if (offset + 30 > limit) then
        padded = buffer(0, limit):bytes()
        padded:set_size(offset + 30)
        padded = padded:tvb("Untruncated payload")
    else
        padded = buffer
    end
    tvbrange = padded(offset + 10, 1)
    subtree = tree:add_le(f.MANUAL_CONTROL_target, tvbrange)
    tvbrange = padded(offset + 0, 2)
    subtree = tree:add_le(f.MANUAL_CONTROL_x, tvbrange)
    tvbrange = padded(offset + 2, 2)
    subtree = tree:add_le(f.MANUAL_CONTROL_y, tvbrange)
    tvbrange = padded(offset + 4, 2)
    subtree = tree:add_le(f.MANUAL_CONTROL_z, tvbrange)
    tvbrange = padded(offset + 6, 2)
    subtree = tree:add_le(f.MANUAL_CONTROL_r, tvbrange)
    tvbrange = padded(offset + 8, 2)
    subtree = tree:add_le(f.MANUAL_CONTROL_buttons, tvbrange)
    tvbrange = padded(offset + 11, 2)
    subtree = tree:add_le(f.MANUAL_CONTROL_buttons2, tvbrange)
    tvbrange = padded(offset + 13, 1)
    subtree = tree:add_le(f.MANUAL_CONTROL_enabled_extensions, tvbrange)
    tvbrange = padded(offset + 14, 2)
    subtree = tree:add_le(f.MANUAL_CONTROL_s, tvbrange)
    tvbrange = padded(offset + 16, 2)
    subtree = tree:add_le(f.MANUAL_CONTROL_t, tvbrange)
    tvbrange = padded(offset + 18, 2)
    subtree = tree:add_le(f.MANUAL_CONTROL_aux1, tvbrange)
    tvbrange = padded(offset + 20, 2)
    subtree = tree:add_le(f.MANUAL_CONTROL_aux2, tvbrange)
    tvbrange = padded(offset + 22, 2)
    subtree = tree:add_le(f.MANUAL_CONTROL_aux3, tvbrange)
    tvbrange = padded(offset + 24, 2)
    subtree = tree:add_le(f.MANUAL_CONTROL_aux4, tvbrange)
    tvbrange = padded(offset + 26, 2)
    subtree = tree:add_le(f.MANUAL_CONTROL_aux5, tvbrange)
    tvbrange = padded(offset + 28, 2)
    subtree = tree:add_le(f.MANUAL_CONTROL_aux6, tvbrange)
end
-- dissect payload of message type COMMAND_INT with command MAV_CMD_GET_MESSAGE_INTERVAL
function payload_fns.payload_75_cmd510(buffer, tree, msgid, offset, limit, pinfo)
    local padded, field_offset, value, subtree, tvbrange
    if (offset + 35 > limit) then
        padded = buffer(0, limit):bytes()
        padded:set_size(offset + 35)
        padded = padded:tvb("Untruncated payload")
    else
        padded = buffer
    end
    tvbrange = padded(offset + 30, 1)
    subtree = tree:add_le(f.COMMAND_INT_target_system, tvbrange)
    tvbrange = padded(offset + 31, 1)
    subtree = tree:add_le(f.COMMAND_INT_target_component, tvbrange)
    tvbrange = padded(offset + 32, 1)
    subtree = tree:add_le(f.COMMAND_INT_frame, tvbrange)
    tvbrange = padded(offset + 28, 2)
    subtree = tree:add_le(f.COMMAND_INT_command, tvbrange)
    tvbrange = padded(offset + 33, 1)
    subtree = tree:add_le(f.COMMAND_INT_current, tvbrange)
    tvbrange = padded(offset + 34, 1)
    subtree = tree:add_le(f.COMMAND_INT_autocontinue, tvbrange)
    tvbrange = padded(offset + 0, 4)
    subtree = tree:add_le(f.cmd_MAV_CMD_GET_MESSAGE_INTERVAL_param1, tvbrange)
    tvbrange = padded(offset + 4, 4)
    subtree = tree:add_le(f.COMMAND_INT_param2, tvbrange)
    tvbrange = padded(offset + 8, 4)
    subtree = tree:add_le(f.COMMAND_INT_param3, tvbrange)
    tvbrange = padded(offset + 12, 4)
    subtree = tree:add_le(f.COMMAND_INT_param4, tvbrange)
    tvbrange = padded(offset + 16, 4)
    subtree = tree:add_le(f.COMMAND_INT_x, tvbrange)
    tvbrange = padded(offset + 20, 4)
    subtree = tree:add_le(f.COMMAND_INT_y, tvbrange)
    tvbrange = padded(offset + 24, 4)
    subtree = tree:add_le(f.COMMAND_INT_z, tvbrange)
end
-- dissect payload of message type COMMAND_INT with command MAV_CMD_SET_MESSAGE_INTERVAL
function payload_fns.payload_75_cmd511(buffer, tree, msgid, offset, limit, pinfo)
    local padded, field_offset, value, subtree, tvbrange
    if (offset + 35 > limit) then
        padded = buffer(0, limit):bytes()
        padded:set_size(offset + 35)
        padded = padded:tvb("Untruncated payload")
    else
        padded = buffer
    end
    tvbrange = padded(offset + 30, 1)
    subtree = tree:add_le(f.COMMAND_INT_target_system, tvbrange)
    tvbrange = padded(offset + 31, 1)
    subtree = tree:add_le(f.COMMAND_INT_target_component, tvbrange)
    tvbrange = padded(offset + 32, 1)
    subtree = tree:add_le(f.COMMAND_INT_frame, tvbrange)
    tvbrange = padded(offset + 28, 2)
    subtree = tree:add_le(f.COMMAND_INT_command, tvbrange)
    tvbrange = padded(offset + 33, 1)
    subtree = tree:add_le(f.COMMAND_INT_current, tvbrange)
    tvbrange = padded(offset + 34, 1)
    subtree = tree:add_le(f.COMMAND_INT_autocontinue, tvbrange)
    tvbrange = padded(offset + 0, 4)
    subtree = tree:add_le(f.cmd_MAV_CMD_SET_MESSAGE_INTERVAL_param1, tvbrange)
    tvbrange = padded(offset + 4, 4)
    subtree = tree:add_le(f.cmd_MAV_CMD_SET_MESSAGE_INTERVAL_param2, tvbrange)
    tvbrange = padded(offset + 8, 4)
    subtree = tree:add_le(f.COMMAND_INT_param3, tvbrange)
    tvbrange = padded(offset + 12, 4)
    subtree = tree:add_le(f.COMMAND_INT_param4, tvbrange)
    tvbrange = padded(offset + 16, 4)
    subtree = tree:add_le(f.COMMAND_INT_x, tvbrange)
    tvbrange = padded(offset + 20, 4)
    subtree = tree:add_le(f.COMMAND_INT_y, tvbrange)
    tvbrange = padded(offset + 24, 4)
    subtree = tree:add_le(f.cmd_MAV_CMD_SET_MESSAGE_INTERVAL_z, tvbrange)
end
-- dissect payload of message type COMMAND_INT with command MAV_CMD_REQUEST_MESSAGE
function payload_fns.payload_75_cmd512(buffer, tree, msgid, offset, limit, pinfo)
    local padded, field_offset, value, subtree, tvbrange
    if (offset + 35 > limit) then
        padded = buffer(0, limit):bytes()
        padded:set_size(offset + 35)
        padded = padded:tvb("Untruncated payload")
    else
        padded = buffer
    end
    tvbrange = padded(offset + 30, 1)
    subtree = tree:add_le(f.COMMAND_INT_target_system, tvbrange)
    tvbrange = padded(offset + 31, 1)
    subtree = tree:add_le(f.COMMAND_INT_target_component, tvbrange)
    tvbrange = padded(offset + 32, 1)
    subtree = tree:add_le(f.COMMAND_INT_frame, tvbrange)
    tvbrange = padded(offset + 28, 2)
    subtree = tree:add_le(f.COMMAND_INT_command, tvbrange)
    tvbrange = padded(offset + 33, 1)
    subtree = tree:add_le(f.COMMAND_INT_current, tvbrange)
    tvbrange = padded(offset + 34, 1)
    subtree = tree:add_le(f.COMMAND_INT_autocontinue, tvbrange)
    tvbrange = padded(offset + 0, 4)
    subtree = tree:add_le(f.cmd_MAV_CMD_REQUEST_MESSAGE_param1, tvbrange)
    tvbrange = padded(offset + 4, 4)
    subtree = tree:add_le(f.cmd_MAV_CMD_REQUEST_MESSAGE_param2, tvbrange)
    tvbrange = padded(offset + 8, 4)
    subtree = tree:add_le(f.cmd_MAV_CMD_REQUEST_MESSAGE_param3, tvbrange)
    tvbrange = padded(offset + 12, 4)
    subtree = tree:add_le(f.cmd_MAV_CMD_REQUEST_MESSAGE_param4, tvbrange)
    tvbrange = padded(offset + 16, 4)
    subtree = tree:add_le(f.cmd_MAV_CMD_REQUEST_MESSAGE_x, tvbrange)
    tvbrange = padded(offset + 20, 4)
    subtree = tree:add_le(f.cmd_MAV_CMD_REQUEST_MESSAGE_y, tvbrange)
    tvbrange = padded(offset + 24, 4)
    subtree = tree:add_le(f.cmd_MAV_CMD_REQUEST_MESSAGE_z, tvbrange)
end
-- dissect payload of message type COMMAND_INT with command MAV_CMD_ROSS_EXPLORE
function payload_fns.payload_75_cmd54000(buffer, tree, msgid, offset, limit, pinfo)
    local padded, field_offset, value, subtree, tvbrange
    if (offset + 35 > limit) then
        padded = buffer(0, limit):bytes()
        padded:set_size(offset + 35)
        padded = padded:tvb("Untruncated payload")
    else
        padded = buffer
    end
    tvbrange = padded(offset + 30, 1)
    subtree = tree:add_le(f.COMMAND_INT_target_system, tvbrange)
    tvbrange = padded(offset + 31, 1)
    subtree = tree:add_le(f.COMMAND_INT_target_component, tvbrange)
    tvbrange = padded(offset + 32, 1)
    subtree = tree:add_le(f.COMMAND_INT_frame, tvbrange)
    tvbrange = padded(offset + 28, 2)
    subtree = tree:add_le(f.COMMAND_INT_command, tvbrange)
    tvbrange = padded(offset + 33, 1)
    subtree = tree:add_le(f.COMMAND_INT_current, tvbrange)
    tvbrange = padded(offset + 34, 1)
    subtree = tree:add_le(f.COMMAND_INT_autocontinue, tvbrange)
    tvbrange = padded(offset + 0, 4)
    subtree = tree:add_le(f.COMMAND_INT_param1, tvbrange)
    tvbrange = padded(offset + 4, 4)
    subtree = tree:add_le(f.COMMAND_INT_param2, tvbrange)
    tvbrange = padded(offset + 8, 4)
    subtree = tree:add_le(f.COMMAND_INT_param3, tvbrange)
    tvbrange = padded(offset + 12, 4)
    subtree = tree:add_le(f.COMMAND_INT_param4, tvbrange)
    tvbrange = padded(offset + 16, 4)
    subtree = tree:add_le(f.COMMAND_INT_x, tvbrange)
    tvbrange = padded(offset + 20, 4)
    subtree = tree:add_le(f.COMMAND_INT_y, tvbrange)
    tvbrange = padded(offset + 24, 4)
    subtree = tree:add_le(f.COMMAND_INT_z, tvbrange)
end
-- dissect payload of message type COMMAND_INT with command MAV_CMD_ROSS_LISTEN
function payload_fns.payload_75_cmd54001(buffer, tree, msgid, offset, limit, pinfo)
    local padded, field_offset, value, subtree, tvbrange
    if (offset + 35 > limit) then
        padded = buffer(0, limit):bytes()
        padded:set_size(offset + 35)
        padded = padded:tvb("Untruncated payload")
    else
        padded = buffer
    end
    tvbrange = padded(offset + 30, 1)
    subtree = tree:add_le(f.COMMAND_INT_target_system, tvbrange)
    tvbrange = padded(offset + 31, 1)
    subtree = tree:add_le(f.COMMAND_INT_target_component, tvbrange)
    tvbrange = padded(offset + 32, 1)
    subtree = tree:add_le(f.COMMAND_INT_frame, tvbrange)
    tvbrange = padded(offset + 28, 2)
    subtree = tree:add_le(f.COMMAND_INT_command, tvbrange)
    tvbrange = padded(offset + 33, 1)
    subtree = tree:add_le(f.COMMAND_INT_current, tvbrange)
    tvbrange = padded(offset + 34, 1)
    subtree = tree:add_le(f.COMMAND_INT_autocontinue, tvbrange)
    tvbrange = padded(offset + 0, 4)
    value = tvbrange:le_float()
    subtree = tree:add_le(f.cmd_MAV_CMD_ROSS_LISTEN_param1, tvbrange, value)
    tvbrange = padded(offset + 4, 4)
    subtree = tree:add_le(f.cmd_MAV_CMD_ROSS_LISTEN_param2, tvbrange)
    tvbrange = padded(offset + 8, 4)
    subtree = tree:add_le(f.cmd_MAV_CMD_ROSS_LISTEN_param3, tvbrange)
    tvbrange = padded(offset + 12, 4)
    subtree = tree:add_le(f.COMMAND_INT_param4, tvbrange)
    tvbrange = padded(offset + 16, 4)
    subtree = tree:add_le(f.COMMAND_INT_x, tvbrange)
    tvbrange = padded(offset + 20, 4)
    subtree = tree:add_le(f.COMMAND_INT_y, tvbrange)
    tvbrange = padded(offset + 24, 4)
    subtree = tree:add_le(f.COMMAND_INT_z, tvbrange)
end
-- dissect payload of message type COMMAND_INT with command MAV_CMD_ROSS_INFORM
function payload_fns.payload_75_cmd54002(buffer, tree, msgid, offset, limit, pinfo)
    local padded, field_offset, value, subtree, tvbrange
    if (offset + 35 > limit) then
        padded = buffer(0, limit):bytes()
        padded:set_size(offset + 35)
        padded = padded:tvb("Untruncated payload")
    else
        padded = buffer
    end
    tvbrange = padded(offset + 30, 1)
    subtree = tree:add_le(f.COMMAND_INT_target_system, tvbrange)
    tvbrange = padded(offset + 31, 1)
    subtree = tree:add_le(f.COMMAND_INT_target_component, tvbrange)
    tvbrange = padded(offset + 32, 1)
    subtree = tree:add_le(f.COMMAND_INT_frame, tvbrange)
    tvbrange = padded(offset + 28, 2)
    subtree = tree:add_le(f.COMMAND_INT_command, tvbrange)
    tvbrange = padded(offset + 33, 1)
    subtree = tree:add_le(f.COMMAND_INT_current, tvbrange)
    tvbrange = padded(offset + 34, 1)
    subtree = tree:add_le(f.COMMAND_INT_autocontinue, tvbrange)
    tvbrange = padded(offset + 0, 4)
    subtree = tree:add_le(f.cmd_MAV_CMD_ROSS_INFORM_param1, tvbrange)
    tvbrange = padded(offset + 4, 4)
    subtree = tree:add_le(f.cmd_MAV_CMD_ROSS_INFORM_param2, tvbrange)
    tvbrange = padded(offset + 8, 4)
    subtree = tree:add_le(f.cmd_MAV_CMD_ROSS_INFORM_param3, tvbrange)
    tvbrange = padded(offset + 12, 4)
    subtree = tree:add_le(f.cmd_MAV_CMD_ROSS_INFORM_param4, tvbrange)
    tvbrange = padded(offset + 16, 4)
    subtree = tree:add_le(f.cmd_MAV_CMD_ROSS_INFORM_x, tvbrange)
    tvbrange = padded(offset + 20, 4)
    subtree = tree:add_le(f.cmd_MAV_CMD_ROSS_INFORM_y, tvbrange)
    tvbrange = padded(offset + 24, 4)
    subtree = tree:add_le(f.cmd_MAV_CMD_ROSS_INFORM_z, tvbrange)
end
-- dissect payload of message type COMMAND_INT with command MAV_CMD_ROSS_TURN
function payload_fns.payload_75_cmd54003(buffer, tree, msgid, offset, limit, pinfo)
    local padded, field_offset, value, subtree, tvbrange
    if (offset + 35 > limit) then
        padded = buffer(0, limit):bytes()
        padded:set_size(offset + 35)
        padded = padded:tvb("Untruncated payload")
    else
        padded = buffer
    end
    tvbrange = padded(offset + 30, 1)
    subtree = tree:add_le(f.COMMAND_INT_target_system, tvbrange)
    tvbrange = padded(offset + 31, 1)
    subtree = tree:add_le(f.COMMAND_INT_target_component, tvbrange)
    tvbrange = padded(offset + 32, 1)
    subtree = tree:add_le(f.COMMAND_INT_frame, tvbrange)
    tvbrange = padded(offset + 28, 2)
    subtree = tree:add_le(f.COMMAND_INT_command, tvbrange)
    tvbrange = padded(offset + 33, 1)
    subtree = tree:add_le(f.COMMAND_INT_current, tvbrange)
    tvbrange = padded(offset + 34, 1)
    subtree = tree:add_le(f.COMMAND_INT_autocontinue, tvbrange)
    tvbrange = padded(offset + 0, 4)
    subtree = tree:add_le(f.cmd_MAV_CMD_ROSS_TURN_param1, tvbrange)
    tvbrange = padded(offset + 4, 4)
    subtree = tree:add_le(f.COMMAND_INT_param2, tvbrange)
    tvbrange = padded(offset + 8, 4)
    subtree = tree:add_le(f.COMMAND_INT_param3, tvbrange)
    tvbrange = padded(offset + 12, 4)
    subtree = tree:add_le(f.COMMAND_INT_param4, tvbrange)
    tvbrange = padded(offset + 16, 4)
    subtree = tree:add_le(f.COMMAND_INT_x, tvbrange)
    tvbrange = padded(offset + 20, 4)
    subtree = tree:add_le(f.COMMAND_INT_y, tvbrange)
    tvbrange = padded(offset + 24, 4)
    subtree = tree:add_le(f.COMMAND_INT_z, tvbrange)
end
-- dissect payload of message type COMMAND_INT with command MAV_CMD_ROSS_STOP
function payload_fns.payload_75_cmd54004(buffer, tree, msgid, offset, limit, pinfo)
    local padded, field_offset, value, subtree, tvbrange
    if (offset + 35 > limit) then
        padded = buffer(0, limit):bytes()
        padded:set_size(offset + 35)
        padded = padded:tvb("Untruncated payload")
    else
        padded = buffer
    end
    tvbrange = padded(offset + 30, 1)
    subtree = tree:add_le(f.COMMAND_INT_target_system, tvbrange)
    tvbrange = padded(offset + 31, 1)
    subtree = tree:add_le(f.COMMAND_INT_target_component, tvbrange)
    tvbrange = padded(offset + 32, 1)
    subtree = tree:add_le(f.COMMAND_INT_frame, tvbrange)
    tvbrange = padded(offset + 28, 2)
    subtree = tree:add_le(f.COMMAND_INT_command, tvbrange)
    tvbrange = padded(offset + 33, 1)
    subtree = tree:add_le(f.COMMAND_INT_current, tvbrange)
    tvbrange = padded(offset + 34, 1)
    subtree = tree:add_le(f.COMMAND_INT_autocontinue, tvbrange)
    tvbrange = padded(offset + 0, 4)
    subtree = tree:add_le(f.COMMAND_INT_param1, tvbrange)
    tvbrange = padded(offset + 4, 4)
    subtree = tree:add_le(f.COMMAND_INT_param2, tvbrange)
    tvbrange = padded(offset + 8, 4)
    subtree = tree:add_le(f.COMMAND_INT_param3, tvbrange)
    tvbrange = padded(offset + 12, 4)
    subtree = tree:add_le(f.COMMAND_INT_param4, tvbrange)
    tvbrange = padded(offset + 16, 4)
    subtree = tree:add_le(f.COMMAND_INT_x, tvbrange)
    tvbrange = padded(offset + 20, 4)
    subtree = tree:add_le(f.COMMAND_INT_y, tvbrange)
    tvbrange = padded(offset + 24, 4)
    subtree = tree:add_le(f.COMMAND_INT_z, tvbrange)
end
-- dissect payload of message type COMMAND_INT with command MAV_CMD_ROSS_CANCEL
function payload_fns.payload_75_cmd54005(buffer, tree, msgid, offset, limit, pinfo)
    local padded, field_offset, value, subtree, tvbrange
    if (offset + 35 > limit) then
        padded = buffer(0, limit):bytes()
        padded:set_size(offset + 35)
        padded = padded:tvb("Untruncated payload")
    else
        padded = buffer
    end
    tvbrange = padded(offset + 30, 1)
    subtree = tree:add_le(f.COMMAND_INT_target_system, tvbrange)
    tvbrange = padded(offset + 31, 1)
    subtree = tree:add_le(f.COMMAND_INT_target_component, tvbrange)
    tvbrange = padded(offset + 32, 1)
    subtree = tree:add_le(f.COMMAND_INT_frame, tvbrange)
    tvbrange = padded(offset + 28, 2)
    subtree = tree:add_le(f.COMMAND_INT_command, tvbrange)
    tvbrange = padded(offset + 33, 1)
    subtree = tree:add_le(f.COMMAND_INT_current, tvbrange)
    tvbrange = padded(offset + 34, 1)
    subtree = tree:add_le(f.COMMAND_INT_autocontinue, tvbrange)
    tvbrange = padded(offset + 0, 4)
    subtree = tree:add_le(f.COMMAND_INT_param1, tvbrange)
    tvbrange = padded(offset + 4, 4)
    subtree = tree:add_le(f.COMMAND_INT_param2, tvbrange)
    tvbrange = padded(offset + 8, 4)
    subtree = tree:add_le(f.COMMAND_INT_param3, tvbrange)
    tvbrange = padded(offset + 12, 4)
    subtree = tree:add_le(f.COMMAND_INT_param4, tvbrange)
    tvbrange = padded(offset + 16, 4)
    subtree = tree:add_le(f.COMMAND_INT_x, tvbrange)
    tvbrange = padded(offset + 20, 4)
    subtree = tree:add_le(f.COMMAND_INT_y, tvbrange)
    tvbrange = padded(offset + 24, 4)
    subtree = tree:add_le(f.COMMAND_INT_z, tvbrange)
end
-- dissect payload of message type COMMAND_INT with command MAV_CMD_ROSS_PARK
function payload_fns.payload_75_cmd54006(buffer, tree, msgid, offset, limit, pinfo)
    local padded, field_offset, value, subtree, tvbrange
    if (offset + 35 > limit) then
        padded = buffer(0, limit):bytes()
        padded:set_size(offset + 35)
        padded = padded:tvb("Untruncated payload")
    else
        padded = buffer
    end
    tvbrange = padded(offset + 30, 1)
    subtree = tree:add_le(f.COMMAND_INT_target_system, tvbrange)
    tvbrange = padded(offset + 31, 1)
    subtree = tree:add_le(f.COMMAND_INT_target_component, tvbrange)
    tvbrange = padded(offset + 32, 1)
    subtree = tree:add_le(f.COMMAND_INT_frame, tvbrange)
    tvbrange = padded(offset + 28, 2)
    subtree = tree:add_le(f.COMMAND_INT_command, tvbrange)
    tvbrange = padded(offset + 33, 1)
    subtree = tree:add_le(f.COMMAND_INT_current, tvbrange)
    tvbrange = padded(offset + 34, 1)
    subtree = tree:add_le(f.COMMAND_INT_autocontinue, tvbrange)
    tvbrange = padded(offset + 0, 4)
    subtree = tree:add_le(f.COMMAND_INT_param1, tvbrange)
    tvbrange = padded(offset + 4, 4)
    subtree = tree:add_le(f.COMMAND_INT_param2, tvbrange)
    tvbrange = padded(offset + 8, 4)
    subtree = tree:add_le(f.COMMAND_INT_param3, tvbrange)
    tvbrange = padded(offset + 12, 4)
    subtree = tree:add_le(f.COMMAND_INT_param4, tvbrange)
    tvbrange = padded(offset + 16, 4)
    subtree = tree:add_le(f.COMMAND_INT_x, tvbrange)
    tvbrange = padded(offset + 20, 4)
    subtree = tree:add_le(f.COMMAND_INT_y, tvbrange)
    tvbrange = padded(offset + 24, 4)
    subtree = tree:add_le(f.COMMAND_INT_z, tvbrange)
end
-- dissect payload of message type COMMAND_INT with command MAV_CMD_ROSS_MEASURE_NOISE
function payload_fns.payload_75_cmd54007(buffer, tree, msgid, offset, limit, pinfo)
    local padded, field_offset, value, subtree, tvbrange
    if (offset + 35 > limit) then
        padded = buffer(0, limit):bytes()
        padded:set_size(offset + 35)
        padded = padded:tvb("Untruncated payload")
    else
        padded = buffer
    end
    tvbrange = padded(offset + 30, 1)
    subtree = tree:add_le(f.COMMAND_INT_target_system, tvbrange)
    tvbrange = padded(offset + 31, 1)
    subtree = tree:add_le(f.COMMAND_INT_target_component, tvbrange)
    tvbrange = padded(offset + 32, 1)
    subtree = tree:add_le(f.COMMAND_INT_frame, tvbrange)
    tvbrange = padded(offset + 28, 2)
    subtree = tree:add_le(f.COMMAND_INT_command, tvbrange)
    tvbrange = padded(offset + 33, 1)
    subtree = tree:add_le(f.COMMAND_INT_current, tvbrange)
    tvbrange = padded(offset + 34, 1)
    subtree = tree:add_le(f.COMMAND_INT_autocontinue, tvbrange)
    tvbrange = padded(offset + 0, 4)
    subtree = tree:add_le(f.cmd_MAV_CMD_ROSS_MEASURE_NOISE_param1, tvbrange)
    tvbrange = padded(offset + 4, 4)
    subtree = tree:add_le(f.COMMAND_INT_param2, tvbrange)
    tvbrange = padded(offset + 8, 4)
    subtree = tree:add_le(f.COMMAND_INT_param3, tvbrange)
    tvbrange = padded(offset + 12, 4)
    subtree = tree:add_le(f.COMMAND_INT_param4, tvbrange)
    tvbrange = padded(offset + 16, 4)
    subtree = tree:add_le(f.COMMAND_INT_x, tvbrange)
    tvbrange = padded(offset + 20, 4)
    subtree = tree:add_le(f.COMMAND_INT_y, tvbrange)
    tvbrange = padded(offset + 24, 4)
    subtree = tree:add_le(f.COMMAND_INT_z, tvbrange)
end
-- dissect payload of message type COMMAND_INT with command MAV_CMD_ROSS_RECORD
function payload_fns.payload_75_cmd54008(buffer, tree, msgid, offset, limit, pinfo)
    local padded, field_offset, value, subtree, tvbrange
    if (offset + 35 > limit) then
        padded = buffer(0, limit):bytes()
        padded:set_size(offset + 35)
        padded = padded:tvb("Untruncated payload")
    else
        padded = buffer
    end
    tvbrange = padded(offset + 30, 1)
    subtree = tree:add_le(f.COMMAND_INT_target_system, tvbrange)
    tvbrange = padded(offset + 31, 1)
    subtree = tree:add_le(f.COMMAND_INT_target_component, tvbrange)
    tvbrange = padded(offset + 32, 1)
    subtree = tree:add_le(f.COMMAND_INT_frame, tvbrange)
    tvbrange = padded(offset + 28, 2)
    subtree = tree:add_le(f.COMMAND_INT_command, tvbrange)
    tvbrange = padded(offset + 33, 1)
    subtree = tree:add_le(f.COMMAND_INT_current, tvbrange)
    tvbrange = padded(offset + 34, 1)
    subtree = tree:add_le(f.COMMAND_INT_autocontinue, tvbrange)
    tvbrange = padded(offset + 0, 4)
    subtree = tree:add_le(f.cmd_MAV_CMD_ROSS_RECORD_param1, tvbrange)
    tvbrange = padded(offset + 4, 4)
    subtree = tree:add_le(f.COMMAND_INT_param2, tvbrange)
    tvbrange = padded(offset + 8, 4)
    subtree = tree:add_le(f.COMMAND_INT_param3, tvbrange)
    tvbrange = padded(offset + 12, 4)
    subtree = tree:add_le(f.COMMAND_INT_param4, tvbrange)
    tvbrange = padded(offset + 16, 4)
    subtree = tree:add_le(f.COMMAND_INT_x, tvbrange)
    tvbrange = padded(offset + 20, 4)
    subtree = tree:add_le(f.COMMAND_INT_y, tvbrange)
    tvbrange = padded(offset + 24, 4)
    subtree = tree:add_le(f.COMMAND_INT_z, tvbrange)
end
-- dissect payload of message type COMMAND_INT with command MAV_CMD_ROSS_REARM
function payload_fns.payload_75_cmd54009(buffer, tree, msgid, offset, limit, pinfo)
    local padded, field_offset, value, subtree, tvbrange
    if (offset + 35 > limit) then
        padded = buffer(0, limit):bytes()
        padded:set_size(offset + 35)
        padded = padded:tvb("Untruncated payload")
    else
        padded = buffer
    end
    tvbrange = padded(offset + 30, 1)
    subtree = tree:add_le(f.COMMAND_INT_target_system, tvbrange)
    tvbrange = padded(offset + 31, 1)
    subtree = tree:add_le(f.COMMAND_INT_target_component, tvbrange)
    tvbrange = padded(offset + 32, 1)
    subtree = tree:add_le(f.COMMAND_INT_frame, tvbrange)
    tvbrange = padded(offset + 28, 2)
    subtree = tree:add_le(f.COMMAND_INT_command, tvbrange)
    tvbrange = padded(offset + 33, 1)
    subtree = tree:add_le(f.COMMAND_INT_current, tvbrange)
    tvbrange = padded(offset + 34, 1)
    subtree = tree:add_le(f.COMMAND_INT_autocontinue, tvbrange)
    tvbrange = padded(offset + 0, 4)
    subtree = tree:add_le(f.COMMAND_INT_param1, tvbrange)
    tvbrange = padded(offset + 4, 4)
    subtree = tree:add_le(f.COMMAND_INT_param2, tvbrange)
    tvbrange = padded(offset + 8, 4)
    subtree = tree:add_le(f.COMMAND_INT_param3, tvbrange)
    tvbrange = padded(offset + 12, 4)
    subtree = tree:add_le(f.COMMAND_INT_param4, tvbrange)
    tvbrange = padded(offset + 16, 4)
    subtree = tree:add_le(f.COMMAND_INT_x, tvbrange)
    tvbrange = padded(offset + 20, 4)
    subtree = tree:add_le(f.COMMAND_INT_y, tvbrange)
    tvbrange = padded(offset + 24, 4)
    subtree = tree:add_le(f.COMMAND_INT_z, tvbrange)
end
-- dissect payload of message type COMMAND_INT with command MAV_CMD_ROSS_HOME
function payload_fns.payload_75_cmd54010(buffer, tree, msgid, offset, limit, pinfo)
    local padded, field_offset, value, subtree, tvbrange
    if (offset + 35 > limit) then
        padded = buffer(0, limit):bytes()
        padded:set_size(offset + 35)
        padded = padded:tvb("Untruncated payload")
    else
        padded = buffer
    end
    tvbrange = padded(offset + 30, 1)
    subtree = tree:add_le(f.COMMAND_INT_target_system, tvbrange)
    tvbrange = padded(offset + 31, 1)
    subtree = tree:add_le(f.COMMAND_INT_target_component, tvbrange)
    tvbrange = padded(offset + 32, 1)
    subtree = tree:add_le(f.COMMAND_INT_frame, tvbrange)
    tvbrange = padded(offset + 28, 2)
    subtree = tree:add_le(f.COMMAND_INT_command, tvbrange)
    tvbrange = padded(offset + 33, 1)
    subtree = tree:add_le(f.COMMAND_INT_current, tvbrange)
    tvbrange = padded(offset + 34, 1)
    subtree = tree:add_le(f.COMMAND_INT_autocontinue, tvbrange)
    tvbrange = padded(offset + 0, 4)
    subtree = tree:add_le(f.COMMAND_INT_param1, tvbrange)
    tvbrange = padded(offset + 4, 4)
    subtree = tree:add_le(f.COMMAND_INT_param2, tvbrange)
    tvbrange = padded(offset + 8, 4)
    subtree = tree:add_le(f.COMMAND_INT_param3, tvbrange)
    tvbrange = padded(offset + 12, 4)
    subtree = tree:add_le(f.COMMAND_INT_param4, tvbrange)
    tvbrange = padded(offset + 16, 4)
    subtree = tree:add_le(f.COMMAND_INT_x, tvbrange)
    tvbrange = padded(offset + 20, 4)
    subtree = tree:add_le(f.COMMAND_INT_y, tvbrange)
    tvbrange = padded(offset + 24, 4)
    subtree = tree:add_le(f.COMMAND_INT_z, tvbrange)
end
-- dissect payload of message type COMMAND_INT with command MAV_CMD_ROSS_STREAM
function payload_fns.payload_75_cmd54011(buffer, tree, msgid, offset, limit, pinfo)
    local padded, field_offset, value, subtree, tvbrange
    if (offset + 35 > limit) then
        padded = buffer(0, limit):bytes()
        padded:set_size(offset + 35)
        padded = padded:tvb("Untruncated payload")
    else
        padded = buffer
    end
    tvbrange = padded(offset + 30, 1)
    subtree = tree:add_le(f.COMMAND_INT_target_system, tvbrange)
    tvbrange = padded(offset + 31, 1)
    subtree = tree:add_le(f.COMMAND_INT_target_component, tvbrange)
    tvbrange = padded(offset + 32, 1)
    subtree = tree:add_le(f.COMMAND_INT_frame, tvbrange)
    tvbrange = padded(offset + 28, 2)
    subtree = tree:add_le(f.COMMAND_INT_command, tvbrange)
    tvbrange = padded(offset + 33, 1)
    subtree = tree:add_le(f.COMMAND_INT_current, tvbrange)
    tvbrange = padded(offset + 34, 1)
    subtree = tree:add_le(f.COMMAND_INT_autocontinue, tvbrange)
    tvbrange = padded(offset + 0, 4)
    subtree = tree:add_le(f.cmd_MAV_CMD_ROSS_STREAM_param1, tvbrange)
    tvbrange = padded(offset + 4, 4)
    value = tvbrange:le_float()
    subtree = tree:add_le(f.cmd_MAV_CMD_ROSS_STREAM_param2, tvbrange, value)
    tvbrange = padded(offset + 8, 4)
    subtree = tree:add_le(f.cmd_MAV_CMD_ROSS_STREAM_param3, tvbrange)
    tvbrange = padded(offset + 12, 4)
    subtree = tree:add_le(f.cmd_MAV_CMD_ROSS_STREAM_param4, tvbrange)
    tvbrange = padded(offset + 16, 4)
    subtree = tree:add_le(f.cmd_MAV_CMD_ROSS_STREAM_x, tvbrange)
    tvbrange = padded(offset + 20, 4)
    subtree = tree:add_le(f.cmd_MAV_CMD_ROSS_STREAM_y, tvbrange)
    tvbrange = padded(offset + 24, 4)
    subtree = tree:add_le(f.cmd_MAV_CMD_ROSS_STREAM_z, tvbrange)
end
-- dissect payload of message type COMMAND_INT with command MAV_CMD_ROSS_ENROL
function payload_fns.payload_75_cmd54012(buffer, tree, msgid, offset, limit, pinfo)
    local padded, field_offset, value, subtree, tvbrange
    if (offset + 35 > limit) then
        padded = buffer(0, limit):bytes()
        padded:set_size(offset + 35)
        padded = padded:tvb("Untruncated payload")
    else
        padded = buffer
    end
    tvbrange = padded(offset + 30, 1)
    subtree = tree:add_le(f.COMMAND_INT_target_system, tvbrange)
    tvbrange = padded(offset + 31, 1)
    subtree = tree:add_le(f.COMMAND_INT_target_component, tvbrange)
    tvbrange = padded(offset + 32, 1)
    subtree = tree:add_le(f.COMMAND_INT_frame, tvbrange)
    tvbrange = padded(offset + 28, 2)
    subtree = tree:add_le(f.COMMAND_INT_command, tvbrange)
    tvbrange = padded(offset + 33, 1)
    subtree = tree:add_le(f.COMMAND_INT_current, tvbrange)
    tvbrange = padded(offset + 34, 1)
    subtree = tree:add_le(f.COMMAND_INT_autocontinue, tvbrange)
    tvbrange = padded(offset + 0, 4)
    value = tvbrange:le_float()
    subtree = tree:add_le(f.cmd_MAV_CMD_ROSS_ENROL_param1, tvbrange, value)
    tvbrange = padded(offset + 4, 4)
    subtree = tree:add_le(f.cmd_MAV_CMD_ROSS_ENROL_param2, tvbrange)
    tvbrange = padded(offset + 8, 4)
    subtree = tree:add_le(f.cmd_MAV_CMD_ROSS_ENROL_param3, tvbrange)
    tvbrange = padded(offset + 12, 4)
    subtree = tree:add_le(f.cmd_MAV_CMD_ROSS_ENROL_param4, tvbrange)
    tvbrange = padded(offset + 16, 4)
    subtree = tree:add_le(f.cmd_MAV_CMD_ROSS_ENROL_x, tvbrange)
    tvbrange = padded(offset + 20, 4)
    subtree = tree:add_le(f.cmd_MAV_CMD_ROSS_ENROL_y, tvbrange)
    tvbrange = padded(offset + 24, 4)
    subtree = tree:add_le(f.COMMAND_INT_z, tvbrange)
end
-- dissect payload of message type COMMAND_INT with command MAV_CMD_ENUM_END
function payload_fns.payload_75_cmd54013(buffer, tree, msgid, offset, limit, pinfo)
    local padded, field_offset, value, subtree, tvbrange
    if (offset + 35 > limit) then
        padded = buffer(0, limit):bytes()
        padded:set_size(offset + 35)
        padded = padded:tvb("Untruncated payload")
    else
        padded = buffer
    end
    tvbrange = padded(offset + 30, 1)
    subtree = tree:add_le(f.COMMAND_INT_target_system, tvbrange)
    tvbrange = padded(offset + 31, 1)
    subtree = tree:add_le(f.COMMAND_INT_target_component, tvbrange)
    tvbrange = padded(offset + 32, 1)
    subtree = tree:add_le(f.COMMAND_INT_frame, tvbrange)
    tvbrange = padded(offset + 28, 2)
    subtree = tree:add_le(f.COMMAND_INT_command, tvbrange)
    tvbrange = padded(offset + 33, 1)
    subtree = tree:add_le(f.COMMAND_INT_current, tvbrange)
    tvbrange = padded(offset + 34, 1)
    subtree = tree:add_le(f.COMMAND_INT_autocontinue, tvbrange)
    tvbrange = padded(offset + 0, 4)
    subtree = tree:add_le(f.COMMAND_INT_param1, tvbrange)
    tvbrange = padded(offset + 4, 4)
    subtree = tree:add_le(f.COMMAND_INT_param2, tvbrange)
    tvbrange = padded(offset + 8, 4)
    subtree = tree:add_le(f.COMMAND_INT_param3, tvbrange)
    tvbrange = padded(offset + 12, 4)
    subtree = tree:add_le(f.COMMAND_INT_param4, tvbrange)
    tvbrange = padded(offset + 16, 4)
    subtree = tree:add_le(f.COMMAND_INT_x, tvbrange)
    tvbrange = padded(offset + 20, 4)
    subtree = tree:add_le(f.COMMAND_INT_y, tvbrange)
    tvbrange = padded(offset + 24, 4)
    subtree = tree:add_le(f.COMMAND_INT_z, tvbrange)
end
-- dissect payload of message type COMMAND_INT
function payload_fns.payload_75(buffer, tree, msgid, offset, limit, pinfo)
    local padded, field_offset, value, subtree, tvbrange
    if (offset + 35 > limit) then
        padded = buffer(0, limit):bytes()
        padded:set_size(offset + 35)
        padded = padded:tvb("Untruncated payload")
    else
        padded = buffer
    end
    local cmd_id = padded(offset + 28, 2):le_uint()
    local cmd_name = enumEntryName.MAV_CMD[cmd_id]
    if cmd_name ~= nil then
        pinfo.cols.info:append(": " .. cmd_name)
    end
    local cmd_fn = payload_fns["payload_75_cmd" .. tostring(cmd_id)]
    if cmd_fn ~= nil then
        cmd_fn(buffer, tree, msgid, offset, limit, pinfo)
        return
    end
    tvbrange = padded(offset + 30, 1)
    subtree = tree:add_le(f.COMMAND_INT_target_system, tvbrange)
    tvbrange = padded(offset + 31, 1)
    subtree = tree:add_le(f.COMMAND_INT_target_component, tvbrange)
    tvbrange = padded(offset + 32, 1)
    subtree = tree:add_le(f.COMMAND_INT_frame, tvbrange)
    tvbrange = padded(offset + 28, 2)
    subtree = tree:add_le(f.COMMAND_INT_command, tvbrange)
    tvbrange = padded(offset + 33, 1)
    subtree = tree:add_le(f.COMMAND_INT_current, tvbrange)
    tvbrange = padded(offset + 34, 1)
    subtree = tree:add_le(f.COMMAND_INT_autocontinue, tvbrange)
    tvbrange = padded(offset + 0, 4)
    subtree = tree:add_le(f.COMMAND_INT_param1, tvbrange)
    tvbrange = padded(offset + 4, 4)
    subtree = tree:add_le(f.COMMAND_INT_param2, tvbrange)
    tvbrange = padded(offset + 8, 4)
    subtree = tree:add_le(f.COMMAND_INT_param3, tvbrange)
    tvbrange = padded(offset + 12, 4)
    subtree = tree:add_le(f.COMMAND_INT_param4, tvbrange)
    tvbrange = padded(offset + 16, 4)
    subtree = tree:add_le(f.COMMAND_INT_x, tvbrange)
    tvbrange = padded(offset + 20, 4)
    subtree = tree:add_le(f.COMMAND_INT_y, tvbrange)
    tvbrange = padded(offset + 24, 4)
    subtree = tree:add_le(f.COMMAND_INT_z, tvbrange)
end
-- dissect payload of message type COMMAND_LONG with command MAV_CMD_GET_MESSAGE_INTERVAL
function payload_fns.payload_76_cmd510(buffer, tree, msgid, offset, limit, pinfo)
    local padded, field_offset, value, subtree, tvbrange
    if (offset + 33 > limit) then
        padded = buffer(0, limit):bytes()
        padded:set_size(offset + 33)
        padded = padded:tvb("Untruncated payload")
    else
        padded = buffer
    end
    tvbrange = padded(offset + 30, 1)
    subtree = tree:add_le(f.COMMAND_LONG_target_system, tvbrange)
    tvbrange = padded(offset + 31, 1)
    subtree = tree:add_le(f.COMMAND_LONG_target_component, tvbrange)
    tvbrange = padded(offset + 28, 2)
    subtree = tree:add_le(f.COMMAND_LONG_command, tvbrange)
    tvbrange = padded(offset + 32, 1)
    subtree = tree:add_le(f.COMMAND_LONG_confirmation, tvbrange)
    tvbrange = padded(offset + 0, 4)
    subtree = tree:add_le(f.cmd_MAV_CMD_GET_MESSAGE_INTERVAL_param1, tvbrange)
    tvbrange = padded(offset + 4, 4)
    subtree = tree:add_le(f.COMMAND_LONG_param2, tvbrange)
    tvbrange = padded(offset + 8, 4)
    subtree = tree:add_le(f.COMMAND_LONG_param3, tvbrange)
    tvbrange = padded(offset + 12, 4)
    subtree = tree:add_le(f.COMMAND_LONG_param4, tvbrange)
    tvbrange = padded(offset + 16, 4)
    subtree = tree:add_le(f.COMMAND_LONG_param5, tvbrange)
    tvbrange = padded(offset + 20, 4)
    subtree = tree:add_le(f.COMMAND_LONG_param6, tvbrange)
    tvbrange = padded(offset + 24, 4)
    subtree = tree:add_le(f.COMMAND_LONG_param7, tvbrange)
end
-- dissect payload of message type COMMAND_LONG with command MAV_CMD_SET_MESSAGE_INTERVAL
function payload_fns.payload_76_cmd511(buffer, tree, msgid, offset, limit, pinfo)
    local padded, field_offset, value, subtree, tvbrange
    if (offset + 33 > limit) then
        padded = buffer(0, limit):bytes()
        padded:set_size(offset + 33)
        padded = padded:tvb("Untruncated payload")
    else
        padded = buffer
    end
    tvbrange = padded(offset + 30, 1)
    subtree = tree:add_le(f.COMMAND_LONG_target_system, tvbrange)
    tvbrange = padded(offset + 31, 1)
    subtree = tree:add_le(f.COMMAND_LONG_target_component, tvbrange)
    tvbrange = padded(offset + 28, 2)
    subtree = tree:add_le(f.COMMAND_LONG_command, tvbrange)
    tvbrange = padded(offset + 32, 1)
    subtree = tree:add_le(f.COMMAND_LONG_confirmation, tvbrange)
    tvbrange = padded(offset + 0, 4)
    subtree = tree:add_le(f.cmd_MAV_CMD_SET_MESSAGE_INTERVAL_param1, tvbrange)
    tvbrange = padded(offset + 4, 4)
    subtree = tree:add_le(f.cmd_MAV_CMD_SET_MESSAGE_INTERVAL_param2, tvbrange)
    tvbrange = padded(offset + 8, 4)
    subtree = tree:add_le(f.COMMAND_LONG_param3, tvbrange)
    tvbrange = padded(offset + 12, 4)
    subtree = tree:add_le(f.COMMAND_LONG_param4, tvbrange)
    tvbrange = padded(offset + 16, 4)
    subtree = tree:add_le(f.COMMAND_LONG_param5, tvbrange)
    tvbrange = padded(offset + 20, 4)
    subtree = tree:add_le(f.COMMAND_LONG_param6, tvbrange)
    tvbrange = padded(offset + 24, 4)
    subtree = tree:add_le(f.cmd_MAV_CMD_SET_MESSAGE_INTERVAL_param7, tvbrange)
end
-- dissect payload of message type COMMAND_LONG with command MAV_CMD_REQUEST_MESSAGE
function payload_fns.payload_76_cmd512(buffer, tree, msgid, offset, limit, pinfo)
    local padded, field_offset, value, subtree, tvbrange
    if (offset + 33 > limit) then
        padded = buffer(0, limit):bytes()
        padded:set_size(offset + 33)
        padded = padded:tvb("Untruncated payload")
    else
        padded = buffer
    end
    tvbrange = padded(offset + 30, 1)
    subtree = tree:add_le(f.COMMAND_LONG_target_system, tvbrange)
    tvbrange = padded(offset + 31, 1)
    subtree = tree:add_le(f.COMMAND_LONG_target_component, tvbrange)
    tvbrange = padded(offset + 28, 2)
    subtree = tree:add_le(f.COMMAND_LONG_command, tvbrange)
    tvbrange = padded(offset + 32, 1)
    subtree = tree:add_le(f.COMMAND_LONG_confirmation, tvbrange)
    tvbrange = padded(offset + 0, 4)
    subtree = tree:add_le(f.cmd_MAV_CMD_REQUEST_MESSAGE_param1, tvbrange)
    tvbrange = padded(offset + 4, 4)
    subtree = tree:add_le(f.cmd_MAV_CMD_REQUEST_MESSAGE_param2, tvbrange)
    tvbrange = padded(offset + 8, 4)
    subtree = tree:add_le(f.cmd_MAV_CMD_REQUEST_MESSAGE_param3, tvbrange)
    tvbrange = padded(offset + 12, 4)
    subtree = tree:add_le(f.cmd_MAV_CMD_REQUEST_MESSAGE_param4, tvbrange)
    tvbrange = padded(offset + 16, 4)
    subtree = tree:add_le(f.cmd_MAV_CMD_REQUEST_MESSAGE_param5, tvbrange)
    tvbrange = padded(offset + 20, 4)
    subtree = tree:add_le(f.cmd_MAV_CMD_REQUEST_MESSAGE_param6, tvbrange)
    tvbrange = padded(offset + 24, 4)
    subtree = tree:add_le(f.cmd_MAV_CMD_REQUEST_MESSAGE_param7, tvbrange)
end
-- dissect payload of message type COMMAND_LONG with command MAV_CMD_ROSS_EXPLORE
function payload_fns.payload_76_cmd54000(buffer, tree, msgid, offset, limit, pinfo)
    local padded, field_offset, value, subtree, tvbrange
    if (offset + 33 > limit) then
        padded = buffer(0, limit):bytes()
        padded:set_size(offset + 33)
        padded = padded:tvb("Untruncated payload")
    else
        padded = buffer
    end
    tvbrange = padded(offset + 30, 1)
    subtree = tree:add_le(f.COMMAND_LONG_target_system, tvbrange)
    tvbrange = padded(offset + 31, 1)
    subtree = tree:add_le(f.COMMAND_LONG_target_component, tvbrange)
    tvbrange = padded(offset + 28, 2)
    subtree = tree:add_le(f.COMMAND_LONG_command, tvbrange)
    tvbrange = padded(offset + 32, 1)
    subtree = tree:add_le(f.COMMAND_LONG_confirmation, tvbrange)
    tvbrange = padded(offset + 0, 4)
    subtree = tree:add_le(f.COMMAND_LONG_param1, tvbrange)
    tvbrange = padded(offset + 4, 4)
    subtree = tree:add_le(f.COMMAND_LONG_param2, tvbrange)
    tvbrange = padded(offset + 8, 4)
    subtree = tree:add_le(f.COMMAND_LONG_param3, tvbrange)
    tvbrange = padded(offset + 12, 4)
    subtree = tree:add_le(f.COMMAND_LONG_param4, tvbrange)
    tvbrange = padded(offset + 16, 4)
    subtree = tree:add_le(f.COMMAND_LONG_param5, tvbrange)
    tvbrange = padded(offset + 20, 4)
    subtree = tree:add_le(f.COMMAND_LONG_param6, tvbrange)
    tvbrange = padded(offset + 24, 4)
    subtree = tree:add_le(f.COMMAND_LONG_param7, tvbrange)
end
-- dissect payload of message type COMMAND_LONG with command MAV_CMD_ROSS_LISTEN
function payload_fns.payload_76_cmd54001(buffer, tree, msgid, offset, limit, pinfo)
    local padded, field_offset, value, subtree, tvbrange
    if (offset + 33 > limit) then
        padded = buffer(0, limit):bytes()
        padded:set_size(offset + 33)
        padded = padded:tvb("Untruncated payload")
    else
        padded = buffer
    end
    tvbrange = padded(offset + 30, 1)
    subtree = tree:add_le(f.COMMAND_LONG_target_system, tvbrange)
    tvbrange = padded(offset + 31, 1)
    subtree = tree:add_le(f.COMMAND_LONG_target_component, tvbrange)
    tvbrange = padded(offset + 28, 2)
    subtree = tree:add_le(f.COMMAND_LONG_command, tvbrange)
    tvbrange = padded(offset + 32, 1)
    subtree = tree:add_le(f.COMMAND_LONG_confirmation, tvbrange)
    tvbrange = padded(offset + 0, 4)
    value = tvbrange:le_float()
    subtree = tree:add_le(f.cmd_MAV_CMD_ROSS_LISTEN_param1, tvbrange, value)
    tvbrange = padded(offset + 4, 4)
    subtree = tree:add_le(f.cmd_MAV_CMD_ROSS_LISTEN_param2, tvbrange)
    tvbrange = padded(offset + 8, 4)
    subtree = tree:add_le(f.cmd_MAV_CMD_ROSS_LISTEN_param3, tvbrange)
    tvbrange = padded(offset + 12, 4)
    subtree = tree:add_le(f.COMMAND_LONG_param4, tvbrange)
    tvbrange = padded(offset + 16, 4)
    subtree = tree:add_le(f.COMMAND_LONG_param5, tvbrange)
    tvbrange = padded(offset + 20, 4)
    subtree = tree:add_le(f.COMMAND_LONG_param6, tvbrange)
    tvbrange = padded(offset + 24, 4)
    subtree = tree:add_le(f.COMMAND_LONG_param7, tvbrange)
end
-- dissect payload of message type COMMAND_LONG with command MAV_CMD_ROSS_INFORM
function payload_fns.payload_76_cmd54002(buffer, tree, msgid, offset, limit, pinfo)
    local padded, field_offset, value, subtree, tvbrange
    if (offset + 33 > limit) then
        padded = buffer(0, limit):bytes()
        padded:set_size(offset + 33)
        padded = padded:tvb("Untruncated payload")
    else
        padded = buffer
    end
    tvbrange = padded(offset + 30, 1)
    subtree = tree:add_le(f.COMMAND_LONG_target_system, tvbrange)
    tvbrange = padded(offset + 31, 1)
    subtree = tree:add_le(f.COMMAND_LONG_target_component, tvbrange)
    tvbrange = padded(offset + 28, 2)
    subtree = tree:add_le(f.COMMAND_LONG_command, tvbrange)
    tvbrange = padded(offset + 32, 1)
    subtree = tree:add_le(f.COMMAND_LONG_confirmation, tvbrange)
    tvbrange = padded(offset + 0, 4)
    subtree = tree:add_le(f.cmd_MAV_CMD_ROSS_INFORM_param1, tvbrange)
    tvbrange = padded(offset + 4, 4)
    subtree = tree:add_le(f.cmd_MAV_CMD_ROSS_INFORM_param2, tvbrange)
    tvbrange = padded(offset + 8, 4)
    subtree = tree:add_le(f.cmd_MAV_CMD_ROSS_INFORM_param3, tvbrange)
    tvbrange = padded(offset + 12, 4)
    subtree = tree:add_le(f.cmd_MAV_CMD_ROSS_INFORM_param4, tvbrange)
    tvbrange = padded(offset + 16, 4)
    subtree = tree:add_le(f.cmd_MAV_CMD_ROSS_INFORM_param5, tvbrange)
    tvbrange = padded(offset + 20, 4)
    subtree = tree:add_le(f.cmd_MAV_CMD_ROSS_INFORM_param6, tvbrange)
    tvbrange = padded(offset + 24, 4)
    subtree = tree:add_le(f.cmd_MAV_CMD_ROSS_INFORM_param7, tvbrange)
end
-- dissect payload of message type COMMAND_LONG with command MAV_CMD_ROSS_TURN
function payload_fns.payload_76_cmd54003(buffer, tree, msgid, offset, limit, pinfo)
    local padded, field_offset, value, subtree, tvbrange
    if (offset + 33 > limit) then
        padded = buffer(0, limit):bytes()
        padded:set_size(offset + 33)
        padded = padded:tvb("Untruncated payload")
    else
        padded = buffer
    end
    tvbrange = padded(offset + 30, 1)
    subtree = tree:add_le(f.COMMAND_LONG_target_system, tvbrange)
    tvbrange = padded(offset + 31, 1)
    subtree = tree:add_le(f.COMMAND_LONG_target_component, tvbrange)
    tvbrange = padded(offset + 28, 2)
    subtree = tree:add_le(f.COMMAND_LONG_command, tvbrange)
    tvbrange = padded(offset + 32, 1)
    subtree = tree:add_le(f.COMMAND_LONG_confirmation, tvbrange)
    tvbrange = padded(offset + 0, 4)
    subtree = tree:add_le(f.cmd_MAV_CMD_ROSS_TURN_param1, tvbrange)
    tvbrange = padded(offset + 4, 4)
    subtree = tree:add_le(f.COMMAND_LONG_param2, tvbrange)
    tvbrange = padded(offset + 8, 4)
    subtree = tree:add_le(f.COMMAND_LONG_param3, tvbrange)
    tvbrange = padded(offset + 12, 4)
    subtree = tree:add_le(f.COMMAND_LONG_param4, tvbrange)
    tvbrange = padded(offset + 16, 4)
    subtree = tree:add_le(f.COMMAND_LONG_param5, tvbrange)
    tvbrange = padded(offset + 20, 4)
    subtree = tree:add_le(f.COMMAND_LONG_param6, tvbrange)
    tvbrange = padded(offset + 24, 4)
    subtree = tree:add_le(f.COMMAND_LONG_param7, tvbrange)
end
-- dissect payload of message type COMMAND_LONG with command MAV_CMD_ROSS_STOP
function payload_fns.payload_76_cmd54004(buffer, tree, msgid, offset, limit, pinfo)
    local padded, field_offset, value, subtree, tvbrange
    if (offset + 33 > limit) then
        padded = buffer(0, limit):bytes()
        padded:set_size(offset + 33)
        padded = padded:tvb("Untruncated payload")
    else
        padded = buffer
    end
    tvbrange = padded(offset + 30, 1)
    subtree = tree:add_le(f.COMMAND_LONG_target_system, tvbrange)
    tvbrange = padded(offset + 31, 1)
    subtree = tree:add_le(f.COMMAND_LONG_target_component, tvbrange)
    tvbrange = padded(offset + 28, 2)
    subtree = tree:add_le(f.COMMAND_LONG_command, tvbrange)
    tvbrange = padded(offset + 32, 1)
    subtree = tree:add_le(f.COMMAND_LONG_confirmation, tvbrange)
    tvbrange = padded(offset + 0, 4)
    subtree = tree:add_le(f.COMMAND_LONG_param1, tvbrange)
    tvbrange = padded(offset + 4, 4)
    subtree = tree:add_le(f.COMMAND_LONG_param2, tvbrange)
    tvbrange = padded(offset + 8, 4)
    subtree = tree:add_le(f.COMMAND_LONG_param3, tvbrange)
    tvbrange = padded(offset + 12, 4)
    subtree = tree:add_le(f.COMMAND_LONG_param4, tvbrange)
    tvbrange = padded(offset + 16, 4)
    subtree = tree:add_le(f.COMMAND_LONG_param5, tvbrange)
    tvbrange = padded(offset + 20, 4)
    subtree = tree:add_le(f.COMMAND_LONG_param6, tvbrange)
    tvbrange = padded(offset + 24, 4)
    subtree = tree:add_le(f.COMMAND_LONG_param7, tvbrange)
end
-- dissect payload of message type COMMAND_LONG with command MAV_CMD_ROSS_CANCEL
function payload_fns.payload_76_cmd54005(buffer, tree, msgid, offset, limit, pinfo)
    local padded, field_offset, value, subtree, tvbrange
    if (offset + 33 > limit) then
        padded = buffer(0, limit):bytes()
        padded:set_size(offset + 33)
        padded = padded:tvb("Untruncated payload")
    else
        padded = buffer
    end
    tvbrange = padded(offset + 30, 1)
    subtree = tree:add_le(f.COMMAND_LONG_target_system, tvbrange)
    tvbrange = padded(offset + 31, 1)
    subtree = tree:add_le(f.COMMAND_LONG_target_component, tvbrange)
    tvbrange = padded(offset + 28, 2)
    subtree = tree:add_le(f.COMMAND_LONG_command, tvbrange)
    tvbrange = padded(offset + 32, 1)
    subtree = tree:add_le(f.COMMAND_LONG_confirmation, tvbrange)
    tvbrange = padded(offset + 0, 4)
    subtree = tree:add_le(f.COMMAND_LONG_param1, tvbrange)
    tvbrange = padded(offset + 4, 4)
    subtree = tree:add_le(f.COMMAND_LONG_param2, tvbrange)
    tvbrange = padded(offset + 8, 4)
    subtree = tree:add_le(f.COMMAND_LONG_param3, tvbrange)
    tvbrange = padded(offset + 12, 4)
    subtree = tree:add_le(f.COMMAND_LONG_param4, tvbrange)
    tvbrange = padded(offset + 16, 4)
    subtree = tree:add_le(f.COMMAND_LONG_param5, tvbrange)
    tvbrange = padded(offset + 20, 4)
    subtree = tree:add_le(f.COMMAND_LONG_param6, tvbrange)
    tvbrange = padded(offset + 24, 4)
    subtree = tree:add_le(f.COMMAND_LONG_param7, tvbrange)
end
-- dissect payload of message type COMMAND_LONG with command MAV_CMD_ROSS_PARK
function payload_fns.payload_76_cmd54006(buffer, tree, msgid, offset, limit, pinfo)
    local padded, field_offset, value, subtree, tvbrange
    if (offset + 33 > limit) then
        padded = buffer(0, limit):bytes()
        padded:set_size(offset + 33)
        padded = padded:tvb("Untruncated payload")
    else
        padded = buffer
    end
    tvbrange = padded(offset + 30, 1)
    subtree = tree:add_le(f.COMMAND_LONG_target_system, tvbrange)
    tvbrange = padded(offset + 31, 1)
    subtree = tree:add_le(f.COMMAND_LONG_target_component, tvbrange)
    tvbrange = padded(offset + 28, 2)
    subtree = tree:add_le(f.COMMAND_LONG_command, tvbrange)
    tvbrange = padded(offset + 32, 1)
    subtree = tree:add_le(f.COMMAND_LONG_confirmation, tvbrange)
    tvbrange = padded(offset + 0, 4)
    subtree = tree:add_le(f.COMMAND_LONG_param1, tvbrange)
    tvbrange = padded(offset + 4, 4)
    subtree = tree:add_le(f.COMMAND_LONG_param2, tvbrange)
    tvbrange = padded(offset + 8, 4)
    subtree = tree:add_le(f.COMMAND_LONG_param3, tvbrange)
    tvbrange = padded(offset + 12, 4)
    subtree = tree:add_le(f.COMMAND_LONG_param4, tvbrange)
    tvbrange = padded(offset + 16, 4)
    subtree = tree:add_le(f.COMMAND_LONG_param5, tvbrange)
    tvbrange = padded(offset + 20, 4)
    subtree = tree:add_le(f.COMMAND_LONG_param6, tvbrange)
    tvbrange = padded(offset + 24, 4)
    subtree = tree:add_le(f.COMMAND_LONG_param7, tvbrange)
end
-- dissect payload of message type COMMAND_LONG with command MAV_CMD_ROSS_MEASURE_NOISE
function payload_fns.payload_76_cmd54007(buffer, tree, msgid, offset, limit, pinfo)
    local padded, field_offset, value, subtree, tvbrange
    if (offset + 33 > limit) then
        padded = buffer(0, limit):bytes()
        padded:set_size(offset + 33)
        padded = padded:tvb("Untruncated payload")
    else
        padded = buffer
    end
    tvbrange = padded(offset + 30, 1)
    subtree = tree:add_le(f.COMMAND_LONG_target_system, tvbrange)
    tvbrange = padded(offset + 31, 1)
    subtree = tree:add_le(f.COMMAND_LONG_target_component, tvbrange)
    tvbrange = padded(offset + 28, 2)
    subtree = tree:add_le(f.COMMAND_LONG_command, tvbrange)
    tvbrange = padded(offset + 32, 1)
    subtree = tree:add_le(f.COMMAND_LONG_confirmation, tvbrange)
    tvbrange = padded(offset + 0, 4)
    subtree = tree:add_le(f.cmd_MAV_CMD_ROSS_MEASURE_NOISE_param1, tvbrange)
    tvbrange = padded(offset + 4, 4)
    subtree = tree:add_le(f.COMMAND_LONG_param2, tvbrange)
    tvbrange = padded(offset + 8, 4)
    subtree = tree:add_le(f.COMMAND_LONG_param3, tvbrange)
    tvbrange = padded(offset + 12, 4)
    subtree = tree:add_le(f.COMMAND_LONG_param4, tvbrange)
    tvbrange = padded(offset + 16, 4)
    subtree = tree:add_le(f.COMMAND_LONG_param5, tvbrange)
    tvbrange = padded(offset + 20, 4)
    subtree = tree:add_le(f.COMMAND_LONG_param6, tvbrange)
    tvbrange = padded(offset + 24, 4)
    subtree = tree:add_le(f.COMMAND_LONG_param7, tvbrange)
end
-- dissect payload of message type COMMAND_LONG with command MAV_CMD_ROSS_RECORD
function payload_fns.payload_76_cmd54008(buffer, tree, msgid, offset, limit, pinfo)
    local padded, field_offset, value, subtree, tvbrange
    if (offset + 33 > limit) then
        padded = buffer(0, limit):bytes()
        padded:set_size(offset + 33)
        padded = padded:tvb("Untruncated payload")
    else
        padded = buffer
    end
    tvbrange = padded(offset + 30, 1)
    subtree = tree:add_le(f.COMMAND_LONG_target_system, tvbrange)
    tvbrange = padded(offset + 31, 1)
    subtree = tree:add_le(f.COMMAND_LONG_target_component, tvbrange)
    tvbrange = padded(offset + 28, 2)
    subtree = tree:add_le(f.COMMAND_LONG_command, tvbrange)
    tvbrange = padded(offset + 32, 1)
    subtree = tree:add_le(f.COMMAND_LONG_confirmation, tvbrange)
    tvbrange = padded(offset + 0, 4)
    subtree = tree:add_le(f.cmd_MAV_CMD_ROSS_RECORD_param1, tvbrange)
    tvbrange = padded(offset + 4, 4)
    subtree = tree:add_le(f.COMMAND_LONG_param2, tvbrange)
    tvbrange = padded(offset + 8, 4)
    subtree = tree:add_le(f.COMMAND_LONG_param3, tvbrange)
    tvbrange = padded(offset + 12, 4)
    subtree = tree:add_le(f.COMMAND_LONG_param4, tvbrange)
    tvbrange = padded(offset + 16, 4)
    subtree = tree:add_le(f.COMMAND_LONG_param5, tvbrange)
    tvbrange = padded(offset + 20, 4)
    subtree = tree:add_le(f.COMMAND_LONG_param6, tvbrange)
    tvbrange = padded(offset + 24, 4)
    subtree = tree:add_le(f.COMMAND_LONG_param7, tvbrange)
end
-- dissect payload of message type COMMAND_LONG with command MAV_CMD_ROSS_REARM
function payload_fns.payload_76_cmd54009(buffer, tree, msgid, offset, limit, pinfo)
    local padded, field_offset, value, subtree, tvbrange
    if (offset + 33 > limit) then
        padded = buffer(0, limit):bytes()
        padded:set_size(offset + 33)
        padded = padded:tvb("Untruncated payload")
    else
        padded = buffer
    end
    tvbrange = padded(offset + 30, 1)
    subtree = tree:add_le(f.COMMAND_LONG_target_system, tvbrange)
    tvbrange = padded(offset + 31, 1)
    subtree = tree:add_le(f.COMMAND_LONG_target_component, tvbrange)
    tvbrange = padded(offset + 28, 2)
    subtree = tree:add_le(f.COMMAND_LONG_command, tvbrange)
    tvbrange = padded(offset + 32, 1)
    subtree = tree:add_le(f.COMMAND_LONG_confirmation, tvbrange)
    tvbrange = padded(offset + 0, 4)
    subtree = tree:add_le(f.COMMAND_LONG_param1, tvbrange)
    tvbrange = padded(offset + 4, 4)
    subtree = tree:add_le(f.COMMAND_LONG_param2, tvbrange)
    tvbrange = padded(offset + 8, 4)
    subtree = tree:add_le(f.COMMAND_LONG_param3, tvbrange)
    tvbrange = padded(offset + 12, 4)
    subtree = tree:add_le(f.COMMAND_LONG_param4, tvbrange)
    tvbrange = padded(offset + 16, 4)
    subtree = tree:add_le(f.COMMAND_LONG_param5, tvbrange)
    tvbrange = padded(offset + 20, 4)
    subtree = tree:add_le(f.COMMAND_LONG_param6, tvbrange)
    tvbrange = padded(offset + 24, 4)
    subtree = tree:add_le(f.COMMAND_LONG_param7, tvbrange)
end
-- dissect payload of message type COMMAND_LONG with command MAV_CMD_ROSS_HOME
function payload_fns.payload_76_cmd54010(buffer, tree, msgid, offset, limit, pinfo)
    local padded, field_offset, value, subtree, tvbrange
    if (offset + 33 > limit) then
        padded = buffer(0, limit):bytes()
        padded:set_size(offset + 33)
        padded = padded:tvb("Untruncated payload")
    else
        padded = buffer
    end
    tvbrange = padded(offset + 30, 1)
    subtree = tree:add_le(f.COMMAND_LONG_target_system, tvbrange)
    tvbrange = padded(offset + 31, 1)
    subtree = tree:add_le(f.COMMAND_LONG_target_component, tvbrange)
    tvbrange = padded(offset + 28, 2)
    subtree = tree:add_le(f.COMMAND_LONG_command, tvbrange)
    tvbrange = padded(offset + 32, 1)
    subtree = tree:add_le(f.COMMAND_LONG_confirmation, tvbrange)
    tvbrange = padded(offset + 0, 4)
    subtree = tree:add_le(f.COMMAND_LONG_param1, tvbrange)
    tvbrange = padded(offset + 4, 4)
    subtree = tree:add_le(f.COMMAND_LONG_param2, tvbrange)
    tvbrange = padded(offset + 8, 4)
    subtree = tree:add_le(f.COMMAND_LONG_param3, tvbrange)
    tvbrange = padded(offset + 12, 4)
    subtree = tree:add_le(f.COMMAND_LONG_param4, tvbrange)
    tvbrange = padded(offset + 16, 4)
    subtree = tree:add_le(f.COMMAND_LONG_param5, tvbrange)
    tvbrange = padded(offset + 20, 4)
    subtree = tree:add_le(f.COMMAND_LONG_param6, tvbrange)
    tvbrange = padded(offset + 24, 4)
    subtree = tree:add_le(f.COMMAND_LONG_param7, tvbrange)
end
-- dissect payload of message type COMMAND_LONG with command MAV_CMD_ROSS_STREAM
function payload_fns.payload_76_cmd54011(buffer, tree, msgid, offset, limit, pinfo)
    local padded, field_offset, value, subtree, tvbrange
    if (offset + 33 > limit) then
        padded = buffer(0, limit):bytes()
        padded:set_size(offset + 33)
        padded = padded:tvb("Untruncated payload")
    else
        padded = buffer
    end
    tvbrange = padded(offset + 30, 1)
    subtree = tree:add_le(f.COMMAND_LONG_target_system, tvbrange)
    tvbrange = padded(offset + 31, 1)
    subtree = tree:add_le(f.COMMAND_LONG_target_component, tvbrange)
    tvbrange = padded(offset + 28, 2)
    subtree = tree:add_le(f.COMMAND_LONG_command, tvbrange)
    tvbrange = padded(offset + 32, 1)
    subtree = tree:add_le(f.COMMAND_LONG_confirmation, tvbrange)
    tvbrange = padded(offset + 0, 4)
    subtree = tree:add_le(f.cmd_MAV_CMD_ROSS_STREAM_param1, tvbrange)
    tvbrange = padded(offset + 4, 4)
    value = tvbrange:le_float()
    subtree = tree:add_le(f.cmd_MAV_CMD_ROSS_STREAM_param2, tvbrange, value)
    tvbrange = padded(offset + 8, 4)
    subtree = tree:add_le(f.cmd_MAV_CMD_ROSS_STREAM_param3, tvbrange)
    tvbrange = padded(offset + 12, 4)
    subtree = tree:add_le(f.cmd_MAV_CMD_ROSS_STREAM_param4, tvbrange)
    tvbrange = padded(offset + 16, 4)
    subtree = tree:add_le(f.cmd_MAV_CMD_ROSS_STREAM_param5, tvbrange)
    tvbrange = padded(offset + 20, 4)
    subtree = tree:add_le(f.cmd_MAV_CMD_ROSS_STREAM_param6, tvbrange)
    tvbrange = padded(offset + 24, 4)
    subtree = tree:add_le(f.cmd_MAV_CMD_ROSS_STREAM_param7, tvbrange)
end
-- dissect payload of message type COMMAND_LONG with command MAV_CMD_ROSS_ENROL
function payload_fns.payload_76_cmd54012(buffer, tree, msgid, offset, limit, pinfo)
    local padded, field_offset, value, subtree, tvbrange
    if (offset + 33 > limit) then
        padded = buffer(0, limit):bytes()
        padded:set_size(offset + 33)
        padded = padded:tvb("Untruncated payload")
    else
        padded = buffer
    end
    tvbrange = padded(offset + 30, 1)
    subtree = tree:add_le(f.COMMAND_LONG_target_system, tvbrange)
    tvbrange = padded(offset + 31, 1)
    subtree = tree:add_le(f.COMMAND_LONG_target_component, tvbrange)
    tvbrange = padded(offset + 28, 2)
    subtree = tree:add_le(f.COMMAND_LONG_command, tvbrange)
    tvbrange = padded(offset + 32, 1)
    subtree = tree:add_le(f.COMMAND_LONG_confirmation, tvbrange)
    tvbrange = padded(offset + 0, 4)
    value = tvbrange:le_float()
    subtree = tree:add_le(f.cmd_MAV_CMD_ROSS_ENROL_param1, tvbrange, value)
    tvbrange = padded(offset + 4, 4)
    subtree = tree:add_le(f.cmd_MAV_CMD_ROSS_ENROL_param2, tvbrange)
    tvbrange = padded(offset + 8, 4)
    subtree = tree:add_le(f.cmd_MAV_CMD_ROSS_ENROL_param3, tvbrange)
    tvbrange = padded(offset + 12, 4)
    subtree = tree:add_le(f.cmd_MAV_CMD_ROSS_ENROL_param4, tvbrange)
    tvbrange = padded(offset + 16, 4)
    subtree = tree:add_le(f.cmd_MAV_CMD_ROSS_ENROL_param5, tvbrange)
    tvbrange = padded(offset + 20, 4)
    subtree = tree:add_le(f.cmd_MAV_CMD_ROSS_ENROL_param6, tvbrange)
    tvbrange = padded(offset + 24, 4)
    subtree = tree:add_le(f.COMMAND_LONG_param7, tvbrange)
end
-- dissect payload of message type COMMAND_LONG with command MAV_CMD_ENUM_END
function payload_fns.payload_76_cmd54013(buffer, tree, msgid, offset, limit, pinfo)
    local padded, field_offset, value, subtree, tvbrange
    if (offset + 33 > limit) then
        padded = buffer(0, limit):bytes()
        padded:set_size(offset + 33)
        padded = padded:tvb("Untruncated payload")
    else
        padded = buffer
    end
    tvbrange = padded(offset + 30, 1)
    subtree = tree:add_le(f.COMMAND_LONG_target_system, tvbrange)
    tvbrange = padded(offset + 31, 1)
    subtree = tree:add_le(f.COMMAND_LONG_target_component, tvbrange)
    tvbrange = padded(offset + 28, 2)
    subtree = tree:add_le(f.COMMAND_LONG_command, tvbrange)
    tvbrange = padded(offset + 32, 1)
    subtree = tree:add_le(f.COMMAND_LONG_confirmation, tvbrange)
    tvbrange = padded(offset + 0, 4)
    subtree = tree:add_le(f.COMMAND_LONG_param1, tvbrange)
    tvbrange = padded(offset + 4, 4)
    subtree = tree:add_le(f.COMMAND_LONG_param2, tvbrange)
    tvbrange = padded(offset + 8, 4)
    subtree = tree:add_le(f.COMMAND_LONG_param3, tvbrange)
    tvbrange = padded(offset + 12, 4)
    subtree = tree:add_le(f.COMMAND_LONG_param4, tvbrange)
    tvbrange = padded(offset + 16, 4)
    subtree = tree:add_le(f.COMMAND_LONG_param5, tvbrange)
    tvbrange = padded(offset + 20, 4)
    subtree = tree:add_le(f.COMMAND_LONG_param6, tvbrange)
    tvbrange = padded(offset + 24, 4)
    subtree = tree:add_le(f.COMMAND_LONG_param7, tvbrange)
end
-- dissect payload of message type COMMAND_LONG
function payload_fns.payload_76(buffer, tree, msgid, offset, limit, pinfo)
    local padded, field_offset, value, subtree, tvbrange
    if (offset + 33 > limit) then
        padded = buffer(0, limit):bytes()
        padded:set_size(offset + 33)
        padded = padded:tvb("Untruncated payload")
    else
        padded = buffer
    end
    local cmd_id = padded(offset + 28, 2):le_uint()
    local cmd_name = enumEntryName.MAV_CMD[cmd_id]
    if cmd_name ~= nil then
        pinfo.cols.info:append(": " .. cmd_name)
    end
    local cmd_fn = payload_fns["payload_76_cmd" .. tostring(cmd_id)]
    if cmd_fn ~= nil then
        cmd_fn(buffer, tree, msgid, offset, limit, pinfo)
        return
    end
    tvbrange = padded(offset + 30, 1)
    subtree = tree:add_le(f.COMMAND_LONG_target_system, tvbrange)
    tvbrange = padded(offset + 31, 1)
    subtree = tree:add_le(f.COMMAND_LONG_target_component, tvbrange)
    tvbrange = padded(offset + 28, 2)
    subtree = tree:add_le(f.COMMAND_LONG_command, tvbrange)
    tvbrange = padded(offset + 32, 1)
    subtree = tree:add_le(f.COMMAND_LONG_confirmation, tvbrange)
    tvbrange = padded(offset + 0, 4)
    subtree = tree:add_le(f.COMMAND_LONG_param1, tvbrange)
    tvbrange = padded(offset + 4, 4)
    subtree = tree:add_le(f.COMMAND_LONG_param2, tvbrange)
    tvbrange = padded(offset + 8, 4)
    subtree = tree:add_le(f.COMMAND_LONG_param3, tvbrange)
    tvbrange = padded(offset + 12, 4)
    subtree = tree:add_le(f.COMMAND_LONG_param4, tvbrange)
    tvbrange = padded(offset + 16, 4)
    subtree = tree:add_le(f.COMMAND_LONG_param5, tvbrange)
    tvbrange = padded(offset + 20, 4)
    subtree = tree:add_le(f.COMMAND_LONG_param6, tvbrange)
    tvbrange = padded(offset + 24, 4)
    subtree = tree:add_le(f.COMMAND_LONG_param7, tvbrange)
end
-- dissect payload of message type COMMAND_ACK
function payload_fns.payload_77(buffer, tree, msgid, offset, limit, pinfo)
    local padded, field_offset, value, subtree, tvbrange
    if (offset + 10 > limit) then
        padded = buffer(0, limit):bytes()
        padded:set_size(offset + 10)
        padded = padded:tvb("Untruncated payload")
    else
        padded = buffer
    end
    local cmd_id = padded(offset + 0, 2):le_uint()
    local cmd_name = enumEntryName.MAV_CMD[cmd_id]
    if cmd_name ~= nil then
        pinfo.cols.info:append(": " .. cmd_name)
    end
    tvbrange = padded(offset + 0, 2)
    subtree = tree:add_le(f.COMMAND_ACK_command, tvbrange)
    tvbrange = padded(offset + 2, 1)
    subtree = tree:add_le(f.COMMAND_ACK_result, tvbrange)
    tvbrange = padded(offset + 3, 1)
    subtree = tree:add_le(f.COMMAND_ACK_progress, tvbrange)
    tvbrange = padded(offset + 4, 4)
    subtree = tree:add_le(f.COMMAND_ACK_result_param2, tvbrange)
    tvbrange = padded(offset + 8, 1)
    subtree = tree:add_le(f.COMMAND_ACK_target_system, tvbrange)
    tvbrange = padded(offset + 9, 1)
    subtree = tree:add_le(f.COMMAND_ACK_target_component, tvbrange)
end
-- dissect payload of message type SET_POSITION_TARGET_LOCAL_NED
function payload_fns.payload_84(buffer, tree, msgid, offset, limit, pinfo)
    local padded, field_offset, value, subtree, tvbrange
    if (offset + 53 > limit) then
        padded = buffer(0, limit):bytes()
        padded:set_size(offset + 53)
        padded = padded:tvb("Untruncated payload")
    else
        padded = buffer
    end
    tvbrange = padded(offset + 0, 4)
    subtree = tree:add_le(f.SET_POSITION_TARGET_LOCAL_NED_time_boot_ms, tvbrange)
    tvbrange = padded(offset + 50, 1)
    subtree = tree:add_le(f.SET_POSITION_TARGET_LOCAL_NED_target_system, tvbrange)
    tvbrange = padded(offset + 51, 1)
    subtree = tree:add_le(f.SET_POSITION_TARGET_LOCAL_NED_target_component, tvbrange)
    tvbrange = padded(offset + 52, 1)
    subtree = tree:add_le(f.SET_POSITION_TARGET_LOCAL_NED_coordinate_frame, tvbrange)
    tvbrange = padded(offset + 48, 2)
    subtree = tree:add_le(f.SET_POSITION_TARGET_LOCAL_NED_type_mask, tvbrange)
    value = tvbrange:le_uint()
    dissect_flags_POSITION_TARGET_TYPEMASK(subtree, "SET_POSITION_TARGET_LOCAL_NED_type_mask", tvbrange, value)
    tvbrange = padded(offset + 4, 4)
    subtree = tree:add_le(f.SET_POSITION_TARGET_LOCAL_NED_x, tvbrange)
    tvbrange = padded(offset + 8, 4)
    subtree = tree:add_le(f.SET_POSITION_TARGET_LOCAL_NED_y, tvbrange)
    tvbrange = padded(offset + 12, 4)
    subtree = tree:add_le(f.SET_POSITION_TARGET_LOCAL_NED_z, tvbrange)
    tvbrange = padded(offset + 16, 4)
    subtree = tree:add_le(f.SET_POSITION_TARGET_LOCAL_NED_vx, tvbrange)
    tvbrange = padded(offset + 20, 4)
    subtree = tree:add_le(f.SET_POSITION_TARGET_LOCAL_NED_vy, tvbrange)
    tvbrange = padded(offset + 24, 4)
    subtree = tree:add_le(f.SET_POSITION_TARGET_LOCAL_NED_vz, tvbrange)
    tvbrange = padded(offset + 28, 4)
    subtree = tree:add_le(f.SET_POSITION_TARGET_LOCAL_NED_afx, tvbrange)
    tvbrange = padded(offset + 32, 4)
    subtree = tree:add_le(f.SET_POSITION_TARGET_LOCAL_NED_afy, tvbrange)
    tvbrange = padded(offset + 36, 4)
    subtree = tree:add_le(f.SET_POSITION_TARGET_LOCAL_NED_afz, tvbrange)
    tvbrange = padded(offset + 40, 4)
    subtree = tree:add_le(f.SET_POSITION_TARGET_LOCAL_NED_yaw, tvbrange)
    value = tvbrange:le_float()
    subtree:append_text(string.format(" (%g deg)",value*180/math.pi))
    tvbrange = padded(offset + 44, 4)
    subtree = tree:add_le(f.SET_POSITION_TARGET_LOCAL_NED_yaw_rate, tvbrange)
    value = tvbrange:le_float()
    subtree:append_text(string.format(" (%g deg/s)",value*180/math.pi))
end
-- dissect payload of message type RADIO_STATUS
function payload_fns.payload_109(buffer, tree, msgid, offset, limit, pinfo)
    local padded, field_offset, value, subtree, tvbrange
    if (offset + 9 > limit) then
        padded = buffer(0, limit):bytes()
        padded:set_size(offset + 9)
        padded = padded:tvb("Untruncated payload")
    else
        padded = buffer
    end
    tvbrange = padded(offset + 4, 1)
    subtree = tree:add_le(f.RADIO_STATUS_rssi, tvbrange)
    tvbrange = padded(offset + 5, 1)
    subtree = tree:add_le(f.RADIO_STATUS_remrssi, tvbrange)
    tvbrange = padded(offset + 6, 1)
    subtree = tree:add_le(f.RADIO_STATUS_txbuf, tvbrange)
    tvbrange = padded(offset + 7, 1)
    subtree = tree:add_le(f.RADIO_STATUS_noise, tvbrange)
    tvbrange = padded(offset + 8, 1)
    subtree = tree:add_le(f.RADIO_STATUS_remnoise, tvbrange)
    tvbrange = padded(offset + 0, 2)
    subtree = tree:add_le(f.RADIO_STATUS_rxerrors, tvbrange)
    tvbrange = padded(offset + 2, 2)
    subtree = tree:add_le(f.RADIO_STATUS_fixed, tvbrange)
end
-- dissect payload of message type FILE_TRANSFER_PROTOCOL
function payload_fns.payload_110(buffer, tree, msgid, offset, limit, pinfo)
    local padded, field_offset, value, subtree, tvbrange
    if (offset + 254 > limit) then
        padded = buffer(0, limit):bytes()
        padded:set_size(offset + 254)
        padded = padded:tvb("Untruncated payload")
    else
        padded = buffer
    end
    tvbrange = padded(offset + 0, 1)
    subtree = tree:add_le(f.FILE_TRANSFER_PROTOCOL_target_network, tvbrange)
    tvbrange = padded(offset + 1, 1)
    subtree = tree:add_le(f.FILE_TRANSFER_PROTOCOL_target_system, tvbrange)
    tvbrange = padded(offset + 2, 1)
    subtree = tree:add_le(f.FILE_TRANSFER_PROTOCOL_target_component, tvbrange)
    ftptree = tree:add(padded(offset + 3, 251), "payload (uint8_t[251])")
    tvbrange = padded(offset + 3 + 0, 2)
    subtree = ftptree:add_le(f.FILE_TRANSFER_PROTOCOL_payload_seq_number, tvbrange)
    tvbrange = padded(offset + 3 + 2, 1)
    subtree = ftptree:add_le(f.FILE_TRANSFER_PROTOCOL_payload_session, tvbrange)
    tvbrange = padded(offset + 3 + 3, 1)
    subtree = ftptree:add_le(f.FILE_TRANSFER_PROTOCOL_payload_opcode, tvbrange)
    tvbrange = padded(offset + 3 + 4, 1)
    payload_size = tvbrange:le_int()
    subtree = ftptree:add_le(f.FILE_TRANSFER_PROTOCOL_payload_size, tvbrange)
    tvbrange = padded(offset + 3 + 5, 1)
    subtree = ftptree:add_le(f.FILE_TRANSFER_PROTOCOL_payload_req_opcode, tvbrange)
    tvbrange = padded(offset + 3 + 6, 1)
    subtree = ftptree:add_le(f.FILE_TRANSFER_PROTOCOL_payload_burst_complete, tvbrange)
    tvbrange = padded(offset + 3 + 8, 4)
    subtree = ftptree:add_le(f.FILE_TRANSFER_PROTOCOL_payload_offset, tvbrange)
    tvbrange = padded(offset + 3 + 12, payload_size)
    subtree = ftptree:add_le(f.FILE_TRANSFER_PROTOCOL_payload_data, tvbrange)
end
-- dissect payload of message type MESSAGE_INTERVAL
function payload_fns.payload_244(buffer, tree, msgid, offset, limit, pinfo)
    local padded, field_offset, value, subtree, tvbrange
    if (offset + 6 > limit) then
        padded = buffer(0, limit):bytes()
        padded:set_size(offset + 6)
        padded = padded:tvb("Untruncated payload")
    else
        padded = buffer
    end
    tvbrange = padded(offset + 4, 2)
    subtree = tree:add_le(f.MESSAGE_INTERVAL_message_id, tvbrange)
    tvbrange = padded(offset + 0, 4)
    subtree = tree:add_le(f.MESSAGE_INTERVAL_interval_us, tvbrange)
    value = tvbrange:le_int()
    subtree:append_text(time_usec_decode(value))
end
-- dissect payload of message type EXTENDED_SYS_STATE
function payload_fns.payload_245(buffer, tree, msgid, offset, limit, pinfo)
    local padded, field_offset, value, subtree, tvbrange
    if (offset + 2 > limit) then
        padded = buffer(0, limit):bytes()
        padded:set_size(offset + 2)
        padded = padded:tvb("Untruncated payload")
    else
        padded = buffer
    end
    tvbrange = padded(offset + 0, 1)
    subtree = tree:add_le(f.EXTENDED_SYS_STATE_vtol_state, tvbrange)
    tvbrange = padded(offset + 1, 1)
    subtree = tree:add_le(f.EXTENDED_SYS_STATE_landed_state, tvbrange)
end
-- dissect payload of message type NAMED_VALUE_FLOAT
function payload_fns.payload_251(buffer, tree, msgid, offset, limit, pinfo)
    local padded, field_offset, value, subtree, tvbrange
    if (offset + 18 > limit) then
        padded = buffer(0, limit):bytes()
        padded:set_size(offset + 18)
        padded = padded:tvb("Untruncated payload")
    else
        padded = buffer
    end
    tvbrange = padded(offset + 0, 4)
    subtree = tree:add_le(f.NAMED_VALUE_FLOAT_time_boot_ms, tvbrange)
    tvbrange = padded(offset + 8, 10)
    subtree = tree:add_le(f.NAMED_VALUE_FLOAT_name, tvbrange)
    tvbrange = padded(offset + 4, 4)
    subtree = tree:add_le(f.NAMED_VALUE_FLOAT_value, tvbrange)
end
-- dissect payload of message type STATUSTEXT
function payload_fns.payload_253(buffer, tree, msgid, offset, limit, pinfo)
    local padded, field_offset, value, subtree, tvbrange
    if (offset + 54 > limit) then
        padded = buffer(0, limit):bytes()
        padded:set_size(offset + 54)
        padded = padded:tvb("Untruncated payload")
    else
        padded = buffer
    end
    tvbrange = padded(offset + 0, 1)
    subtree = tree:add_le(f.STATUSTEXT_severity, tvbrange)
    tvbrange = padded(offset + 1, 50)
    subtree = tree:add_le(f.STATUSTEXT_text, tvbrange)
    tvbrange = padded(offset + 51, 2)
    subtree = tree:add_le(f.STATUSTEXT_id, tvbrange)
    tvbrange = padded(offset + 53, 1)
    subtree = tree:add_le(f.STATUSTEXT_chunk_seq, tvbrange)
end
-- dissect payload of message type GIMBAL_MANAGER_INFORMATION
function payload_fns.payload_280(buffer, tree, msgid, offset, limit, pinfo)
    local padded, field_offset, value, subtree, tvbrange
    if (offset + 33 > limit) then
        padded = buffer(0, limit):bytes()
        padded:set_size(offset + 33)
        padded = padded:tvb("Untruncated payload")
    else
        padded = buffer
    end
    tvbrange = padded(offset + 0, 4)
    subtree = tree:add_le(f.GIMBAL_MANAGER_INFORMATION_time_boot_ms, tvbrange)
    tvbrange = padded(offset + 4, 4)
    subtree = tree:add_le(f.GIMBAL_MANAGER_INFORMATION_cap_flags, tvbrange)
    value = tvbrange:le_uint()
    dissect_flags_GIMBAL_MANAGER_CAP_FLAGS(subtree, "GIMBAL_MANAGER_INFORMATION_cap_flags", tvbrange, value)
    tvbrange = padded(offset + 32, 1)
    subtree = tree:add_le(f.GIMBAL_MANAGER_INFORMATION_gimbal_device_id, tvbrange)
    tvbrange = padded(offset + 8, 4)
    subtree = tree:add_le(f.GIMBAL_MANAGER_INFORMATION_roll_min, tvbrange)
    value = tvbrange:le_float()
    subtree:append_text(string.format(" (%g deg)",value*180/math.pi))
    tvbrange = padded(offset + 12, 4)
    subtree = tree:add_le(f.GIMBAL_MANAGER_INFORMATION_roll_max, tvbrange)
    value = tvbrange:le_float()
    subtree:append_text(string.format(" (%g deg)",value*180/math.pi))
    tvbrange = padded(offset + 16, 4)
    subtree = tree:add_le(f.GIMBAL_MANAGER_INFORMATION_pitch_min, tvbrange)
    value = tvbrange:le_float()
    subtree:append_text(string.format(" (%g deg)",value*180/math.pi))
    tvbrange = padded(offset + 20, 4)
    subtree = tree:add_le(f.GIMBAL_MANAGER_INFORMATION_pitch_max, tvbrange)
    value = tvbrange:le_float()
    subtree:append_text(string.format(" (%g deg)",value*180/math.pi))
    tvbrange = padded(offset + 24, 4)
    subtree = tree:add_le(f.GIMBAL_MANAGER_INFORMATION_yaw_min, tvbrange)
    value = tvbrange:le_float()
    subtree:append_text(string.format(" (%g deg)",value*180/math.pi))
    tvbrange = padded(offset + 28, 4)
    subtree = tree:add_le(f.GIMBAL_MANAGER_INFORMATION_yaw_max, tvbrange)
    value = tvbrange:le_float()
    subtree:append_text(string.format(" (%g deg)",value*180/math.pi))
end
-- dissect payload of message type GIMBAL_MANAGER_STATUS
function payload_fns.payload_281(buffer, tree, msgid, offset, limit, pinfo)
    local padded, field_offset, value, subtree, tvbrange
    if (offset + 13 > limit) then
        padded = buffer(0, limit):bytes()
        padded:set_size(offset + 13)
        padded = padded:tvb("Untruncated payload")
    else
        padded = buffer
    end
    tvbrange = padded(offset + 0, 4)
    subtree = tree:add_le(f.GIMBAL_MANAGER_STATUS_time_boot_ms, tvbrange)
    tvbrange = padded(offset + 4, 4)
    subtree = tree:add_le(f.GIMBAL_MANAGER_STATUS_flags, tvbrange)
    value = tvbrange:le_uint()
    dissect_flags_GIMBAL_MANAGER_FLAGS(subtree, "GIMBAL_MANAGER_STATUS_flags", tvbrange, value)
    tvbrange = padded(offset + 8, 1)
    subtree = tree:add_le(f.GIMBAL_MANAGER_STATUS_gimbal_device_id, tvbrange)
    tvbrange = padded(offset + 9, 1)
    subtree = tree:add_le(f.GIMBAL_MANAGER_STATUS_primary_control_sysid, tvbrange)
    tvbrange = padded(offset + 10, 1)
    subtree = tree:add_le(f.GIMBAL_MANAGER_STATUS_primary_control_compid, tvbrange)
    tvbrange = padded(offset + 11, 1)
    subtree = tree:add_le(f.GIMBAL_MANAGER_STATUS_secondary_control_sysid, tvbrange)
    tvbrange = padded(offset + 12, 1)
    subtree = tree:add_le(f.GIMBAL_MANAGER_STATUS_secondary_control_compid, tvbrange)
end
-- dissect payload of message type GIMBAL_MANAGER_SET_ATTITUDE
function payload_fns.payload_282(buffer, tree, msgid, offset, limit, pinfo)
    local padded, field_offset, value, subtree, tvbrange
    if (offset + 35 > limit) then
        padded = buffer(0, limit):bytes()
        padded:set_size(offset + 35)
        padded = padded:tvb("Untruncated payload")
    else
        padded = buffer
    end
    tvbrange = padded(offset + 32, 1)
    subtree = tree:add_le(f.GIMBAL_MANAGER_SET_ATTITUDE_target_system, tvbrange)
    tvbrange = padded(offset + 33, 1)
    subtree = tree:add_le(f.GIMBAL_MANAGER_SET_ATTITUDE_target_component, tvbrange)
    tvbrange = padded(offset + 0, 4)
    subtree = tree:add_le(f.GIMBAL_MANAGER_SET_ATTITUDE_flags, tvbrange)
    value = tvbrange:le_uint()
    dissect_flags_GIMBAL_MANAGER_FLAGS(subtree, "GIMBAL_MANAGER_SET_ATTITUDE_flags", tvbrange, value)
    tvbrange = padded(offset + 34, 1)
    subtree = tree:add_le(f.GIMBAL_MANAGER_SET_ATTITUDE_gimbal_device_id, tvbrange)
    for i = 0, 3 do
        tvbrange = padded(offset + 4 + 4 * i, 4)
        subtree = tree:add_le(f["GIMBAL_MANAGER_SET_ATTITUDE_q_"..i], tvbrange)
    end
    tvbrange = padded(offset + 20, 4)
    subtree = tree:add_le(f.GIMBAL_MANAGER_SET_ATTITUDE_angular_velocity_x, tvbrange)
    value = tvbrange:le_float()
    subtree:append_text(string.format(" (%g deg/s)",value*180/math.pi))
    tvbrange = padded(offset + 24, 4)
    subtree = tree:add_le(f.GIMBAL_MANAGER_SET_ATTITUDE_angular_velocity_y, tvbrange)
    value = tvbrange:le_float()
    subtree:append_text(string.format(" (%g deg/s)",value*180/math.pi))
    tvbrange = padded(offset + 28, 4)
    subtree = tree:add_le(f.GIMBAL_MANAGER_SET_ATTITUDE_angular_velocity_z, tvbrange)
    value = tvbrange:le_float()
    subtree:append_text(string.format(" (%g deg/s)",value*180/math.pi))
end
-- dissect payload of message type GIMBAL_DEVICE_INFORMATION
function payload_fns.payload_283(buffer, tree, msgid, offset, limit, pinfo)
    local padded, field_offset, value, subtree, tvbrange
    if (offset + 149 > limit) then
        padded = buffer(0, limit):bytes()
        padded:set_size(offset + 149)
        padded = padded:tvb("Untruncated payload")
    else
        padded = buffer
    end
    tvbrange = padded(offset + 8, 4)
    subtree = tree:add_le(f.GIMBAL_DEVICE_INFORMATION_time_boot_ms, tvbrange)
    tvbrange = padded(offset + 48, 32)
    subtree = tree:add_le(f.GIMBAL_DEVICE_INFORMATION_vendor_name, tvbrange)
    tvbrange = padded(offset + 80, 32)
    subtree = tree:add_le(f.GIMBAL_DEVICE_INFORMATION_model_name, tvbrange)
    tvbrange = padded(offset + 112, 32)
    subtree = tree:add_le(f.GIMBAL_DEVICE_INFORMATION_custom_name, tvbrange)
    tvbrange = padded(offset + 12, 4)
    subtree = tree:add_le(f.GIMBAL_DEVICE_INFORMATION_firmware_version, tvbrange)
    tvbrange = padded(offset + 16, 4)
    subtree = tree:add_le(f.GIMBAL_DEVICE_INFORMATION_hardware_version, tvbrange)
    tvbrange = padded(offset + 0, 8)
    subtree = tree:add_le(f.GIMBAL_DEVICE_INFORMATION_uid, tvbrange)
    tvbrange = padded(offset + 44, 2)
    subtree = tree:add_le(f.GIMBAL_DEVICE_INFORMATION_cap_flags, tvbrange)
    value = tvbrange:le_uint()
    dissect_flags_GIMBAL_DEVICE_CAP_FLAGS(subtree, "GIMBAL_DEVICE_INFORMATION_cap_flags", tvbrange, value)
    tvbrange = padded(offset + 46, 2)
    subtree = tree:add_le(f.GIMBAL_DEVICE_INFORMATION_custom_cap_flags, tvbrange)
    tvbrange = padded(offset + 20, 4)
    subtree = tree:add_le(f.GIMBAL_DEVICE_INFORMATION_roll_min, tvbrange)
    value = tvbrange:le_float()
    subtree:append_text(string.format(" (%g deg)",value*180/math.pi))
    tvbrange = padded(offset + 24, 4)
    subtree = tree:add_le(f.GIMBAL_DEVICE_INFORMATION_roll_max, tvbrange)
    value = tvbrange:le_float()
    subtree:append_text(string.format(" (%g deg)",value*180/math.pi))
    tvbrange = padded(offset + 28, 4)
    subtree = tree:add_le(f.GIMBAL_DEVICE_INFORMATION_pitch_min, tvbrange)
    value = tvbrange:le_float()
    subtree:append_text(string.format(" (%g deg)",value*180/math.pi))
    tvbrange = padded(offset + 32, 4)
    subtree = tree:add_le(f.GIMBAL_DEVICE_INFORMATION_pitch_max, tvbrange)
    value = tvbrange:le_float()
    subtree:append_text(string.format(" (%g deg)",value*180/math.pi))
    tvbrange = padded(offset + 36, 4)
    subtree = tree:add_le(f.GIMBAL_DEVICE_INFORMATION_yaw_min, tvbrange)
    value = tvbrange:le_float()
    subtree:append_text(string.format(" (%g deg)",value*180/math.pi))
    tvbrange = padded(offset + 40, 4)
    subtree = tree:add_le(f.GIMBAL_DEVICE_INFORMATION_yaw_max, tvbrange)
    value = tvbrange:le_float()
    subtree:append_text(string.format(" (%g deg)",value*180/math.pi))
    tvbrange = padded(offset + 144, 1)
    subtree = tree:add_le(f.GIMBAL_DEVICE_INFORMATION_gimbal_device_id, tvbrange)
    tvbrange = padded(offset + 145, 4)
    subtree = tree:add_le(f.GIMBAL_DEVICE_INFORMATION_cap_flags2, tvbrange)
    value = tvbrange:le_uint()
    dissect_flags_GIMBAL_DEVICE_CAP_FLAGS(subtree, "GIMBAL_DEVICE_INFORMATION_cap_flags2", tvbrange, value)
end
-- dissect payload of message type GIMBAL_DEVICE_SET_ATTITUDE
function payload_fns.payload_284(buffer, tree, msgid, offset, limit, pinfo)
    local padded, field_offset, value, subtree, tvbrange
    if (offset + 32 > limit) then
        padded = buffer(0, limit):bytes()
        padded:set_size(offset + 32)
        padded = padded:tvb("Untruncated payload")
    else
        padded = buffer
    end
    tvbrange = padded(offset + 30, 1)
    subtree = tree:add_le(f.GIMBAL_DEVICE_SET_ATTITUDE_target_system, tvbrange)
    tvbrange = padded(offset + 31, 1)
    subtree = tree:add_le(f.GIMBAL_DEVICE_SET_ATTITUDE_target_component, tvbrange)
    tvbrange = padded(offset + 28, 2)
    subtree = tree:add_le(f.GIMBAL_DEVICE_SET_ATTITUDE_flags, tvbrange)
    value = tvbrange:le_uint()
    dissect_flags_GIMBAL_DEVICE_FLAGS(subtree, "GIMBAL_DEVICE_SET_ATTITUDE_flags", tvbrange, value)
    for i = 0, 3 do
        tvbrange = padded(offset + 0 + 4 * i, 4)
        subtree = tree:add_le(f["GIMBAL_DEVICE_SET_ATTITUDE_q_"..i], tvbrange)
    end
    tvbrange = padded(offset + 16, 4)
    subtree = tree:add_le(f.GIMBAL_DEVICE_SET_ATTITUDE_angular_velocity_x, tvbrange)
    value = tvbrange:le_float()
    subtree:append_text(string.format(" (%g deg/s)",value*180/math.pi))
    tvbrange = padded(offset + 20, 4)
    subtree = tree:add_le(f.GIMBAL_DEVICE_SET_ATTITUDE_angular_velocity_y, tvbrange)
    value = tvbrange:le_float()
    subtree:append_text(string.format(" (%g deg/s)",value*180/math.pi))
    tvbrange = padded(offset + 24, 4)
    subtree = tree:add_le(f.GIMBAL_DEVICE_SET_ATTITUDE_angular_velocity_z, tvbrange)
    value = tvbrange:le_float()
    subtree:append_text(string.format(" (%g deg/s)",value*180/math.pi))
end
-- dissect payload of message type GIMBAL_DEVICE_ATTITUDE_STATUS
function payload_fns.payload_285(buffer, tree, msgid, offset, limit, pinfo)
    local padded, field_offset, value, subtree, tvbrange
    if (offset + 49 > limit) then
        padded = buffer(0, limit):bytes()
        padded:set_size(offset + 49)
        padded = padded:tvb("Untruncated payload")
    else
        padded = buffer
    end
    tvbrange = padded(offset + 38, 1)
    subtree = tree:add_le(f.GIMBAL_DEVICE_ATTITUDE_STATUS_target_system, tvbrange)
    tvbrange = padded(offset + 39, 1)
    subtree = tree:add_le(f.GIMBAL_DEVICE_ATTITUDE_STATUS_target_component, tvbrange)
    tvbrange = padded(offset + 0, 4)
    subtree = tree:add_le(f.GIMBAL_DEVICE_ATTITUDE_STATUS_time_boot_ms, tvbrange)
    tvbrange = padded(offset + 36, 2)
    subtree = tree:add_le(f.GIMBAL_DEVICE_ATTITUDE_STATUS_flags, tvbrange)
    value = tvbrange:le_uint()
    dissect_flags_GIMBAL_DEVICE_FLAGS(subtree, "GIMBAL_DEVICE_ATTITUDE_STATUS_flags", tvbrange, value)
    for i = 0, 3 do
        tvbrange = padded(offset + 4 + 4 * i, 4)
        subtree = tree:add_le(f["GIMBAL_DEVICE_ATTITUDE_STATUS_q_"..i], tvbrange)
    end
    tvbrange = padded(offset + 20, 4)
    subtree = tree:add_le(f.GIMBAL_DEVICE_ATTITUDE_STATUS_angular_velocity_x, tvbrange)
    value = tvbrange:le_float()
    subtree:append_text(string.format(" (%g deg/s)",value*180/math.pi))
    tvbrange = padded(offset + 24, 4)
    subtree = tree:add_le(f.GIMBAL_DEVICE_ATTITUDE_STATUS_angular_velocity_y, tvbrange)
    value = tvbrange:le_float()
    subtree:append_text(string.format(" (%g deg/s)",value*180/math.pi))
    tvbrange = padded(offset + 28, 4)
    subtree = tree:add_le(f.GIMBAL_DEVICE_ATTITUDE_STATUS_angular_velocity_z, tvbrange)
    value = tvbrange:le_float()
    subtree:append_text(string.format(" (%g deg/s)",value*180/math.pi))
    tvbrange = padded(offset + 32, 4)
    subtree = tree:add_le(f.GIMBAL_DEVICE_ATTITUDE_STATUS_failure_flags, tvbrange)
    value = tvbrange:le_uint()
    dissect_flags_GIMBAL_DEVICE_ERROR_FLAGS(subtree, "GIMBAL_DEVICE_ATTITUDE_STATUS_failure_flags", tvbrange, value)
    tvbrange = padded(offset + 40, 4)
    subtree = tree:add_le(f.GIMBAL_DEVICE_ATTITUDE_STATUS_delta_yaw, tvbrange)
    value = tvbrange:le_float()
    subtree:append_text(string.format(" (%g deg)",value*180/math.pi))
    tvbrange = padded(offset + 44, 4)
    subtree = tree:add_le(f.GIMBAL_DEVICE_ATTITUDE_STATUS_delta_yaw_velocity, tvbrange)
    value = tvbrange:le_float()
    subtree:append_text(string.format(" (%g deg/s)",value*180/math.pi))
    tvbrange = padded(offset + 48, 1)
    subtree = tree:add_le(f.GIMBAL_DEVICE_ATTITUDE_STATUS_gimbal_device_id, tvbrange)
end
-- dissect payload of message type AUTOPILOT_STATE_FOR_GIMBAL_DEVICE
function payload_fns.payload_286(buffer, tree, msgid, offset, limit, pinfo)
    local padded, field_offset, value, subtree, tvbrange
    if (offset + 57 > limit) then
        padded = buffer(0, limit):bytes()
        padded:set_size(offset + 57)
        padded = padded:tvb("Untruncated payload")
    else
        padded = buffer
    end
    tvbrange = padded(offset + 50, 1)
    subtree = tree:add_le(f.AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_target_system, tvbrange)
    tvbrange = padded(offset + 51, 1)
    subtree = tree:add_le(f.AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_target_component, tvbrange)
    tvbrange = padded(offset + 0, 8)
    subtree = tree:add_le(f.AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_time_boot_us, tvbrange)
    value = tvbrange:le_uint64()
    subtree:append_text(time_usec_decode(value))
    for i = 0, 3 do
        tvbrange = padded(offset + 8 + 4 * i, 4)
        subtree = tree:add_le(f["AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_q_"..i], tvbrange)
    end
    tvbrange = padded(offset + 24, 4)
    subtree = tree:add_le(f.AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_q_estimated_delay_us, tvbrange)
    value = tvbrange:le_uint()
    subtree:append_text(time_usec_decode(value))
    tvbrange = padded(offset + 28, 4)
    subtree = tree:add_le(f.AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_vx, tvbrange)
    tvbrange = padded(offset + 32, 4)
    subtree = tree:add_le(f.AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_vy, tvbrange)
    tvbrange = padded(offset + 36, 4)
    subtree = tree:add_le(f.AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_vz, tvbrange)
    tvbrange = padded(offset + 40, 4)
    subtree = tree:add_le(f.AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_v_estimated_delay_us, tvbrange)
    value = tvbrange:le_uint()
    subtree:append_text(time_usec_decode(value))
    tvbrange = padded(offset + 44, 4)
    subtree = tree:add_le(f.AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_feed_forward_angular_velocity_z, tvbrange)
    value = tvbrange:le_float()
    subtree:append_text(string.format(" (%g deg/s)",value*180/math.pi))
    tvbrange = padded(offset + 48, 2)
    subtree = tree:add_le(f.AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_estimator_status, tvbrange)
    value = tvbrange:le_uint()
    dissect_flags_ESTIMATOR_STATUS_FLAGS(subtree, "AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_estimator_status", tvbrange, value)
    tvbrange = padded(offset + 52, 1)
    subtree = tree:add_le(f.AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_landed_state, tvbrange)
    tvbrange = padded(offset + 53, 4)
    subtree = tree:add_le(f.AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_angular_velocity_z, tvbrange)
    value = tvbrange:le_float()
    subtree:append_text(string.format(" (%g deg/s)",value*180/math.pi))
end
-- dissect payload of message type GIMBAL_MANAGER_SET_PITCHYAW
function payload_fns.payload_287(buffer, tree, msgid, offset, limit, pinfo)
    local padded, field_offset, value, subtree, tvbrange
    if (offset + 23 > limit) then
        padded = buffer(0, limit):bytes()
        padded:set_size(offset + 23)
        padded = padded:tvb("Untruncated payload")
    else
        padded = buffer
    end
    tvbrange = padded(offset + 20, 1)
    subtree = tree:add_le(f.GIMBAL_MANAGER_SET_PITCHYAW_target_system, tvbrange)
    tvbrange = padded(offset + 21, 1)
    subtree = tree:add_le(f.GIMBAL_MANAGER_SET_PITCHYAW_target_component, tvbrange)
    tvbrange = padded(offset + 0, 4)
    subtree = tree:add_le(f.GIMBAL_MANAGER_SET_PITCHYAW_flags, tvbrange)
    value = tvbrange:le_uint()
    dissect_flags_GIMBAL_MANAGER_FLAGS(subtree, "GIMBAL_MANAGER_SET_PITCHYAW_flags", tvbrange, value)
    tvbrange = padded(offset + 22, 1)
    subtree = tree:add_le(f.GIMBAL_MANAGER_SET_PITCHYAW_gimbal_device_id, tvbrange)
    tvbrange = padded(offset + 4, 4)
    subtree = tree:add_le(f.GIMBAL_MANAGER_SET_PITCHYAW_pitch, tvbrange)
    value = tvbrange:le_float()
    subtree:append_text(string.format(" (%g deg)",value*180/math.pi))
    tvbrange = padded(offset + 8, 4)
    subtree = tree:add_le(f.GIMBAL_MANAGER_SET_PITCHYAW_yaw, tvbrange)
    value = tvbrange:le_float()
    subtree:append_text(string.format(" (%g deg)",value*180/math.pi))
    tvbrange = padded(offset + 12, 4)
    subtree = tree:add_le(f.GIMBAL_MANAGER_SET_PITCHYAW_pitch_rate, tvbrange)
    value = tvbrange:le_float()
    subtree:append_text(string.format(" (%g deg/s)",value*180/math.pi))
    tvbrange = padded(offset + 16, 4)
    subtree = tree:add_le(f.GIMBAL_MANAGER_SET_PITCHYAW_yaw_rate, tvbrange)
    value = tvbrange:le_float()
    subtree:append_text(string.format(" (%g deg/s)",value*180/math.pi))
end
-- dissect payload of message type PARAM_ERROR
function payload_fns.payload_345(buffer, tree, msgid, offset, limit, pinfo)
    local padded, field_offset, value, subtree, tvbrange
    if (offset + 21 > limit) then
        padded = buffer(0, limit):bytes()
        padded:set_size(offset + 21)
        padded = padded:tvb("Untruncated payload")
    else
        padded = buffer
    end
    tvbrange = padded(offset + 2, 1)
    subtree = tree:add_le(f.PARAM_ERROR_target_system, tvbrange)
    tvbrange = padded(offset + 3, 1)
    subtree = tree:add_le(f.PARAM_ERROR_target_component, tvbrange)
    tvbrange = padded(offset + 4, 16)
    subtree = tree:add_le(f.PARAM_ERROR_param_id, tvbrange)
    tvbrange = padded(offset + 0, 2)
    subtree = tree:add_le(f.PARAM_ERROR_param_index, tvbrange)
    tvbrange = padded(offset + 20, 1)
    subtree = tree:add_le(f.PARAM_ERROR_error, tvbrange)
end
-- dissect payload of message type DEBUG_FLOAT_ARRAY
function payload_fns.payload_350(buffer, tree, msgid, offset, limit, pinfo)
    local padded, field_offset, value, subtree, tvbrange
    if (offset + 252 > limit) then
        padded = buffer(0, limit):bytes()
        padded:set_size(offset + 252)
        padded = padded:tvb("Untruncated payload")
    else
        padded = buffer
    end
    tvbrange = padded(offset + 0, 8)
    subtree = tree:add_le(f.DEBUG_FLOAT_ARRAY_time_usec, tvbrange)
    value = tvbrange:le_uint64()
    subtree:append_text(time_usec_decode(value))
    tvbrange = padded(offset + 10, 10)
    subtree = tree:add_le(f.DEBUG_FLOAT_ARRAY_name, tvbrange)
    tvbrange = padded(offset + 8, 2)
    subtree = tree:add_le(f.DEBUG_FLOAT_ARRAY_array_id, tvbrange)
    for i = 0, 57 do
        tvbrange = padded(offset + 20 + 4 * i, 4)
        subtree = tree:add_le(f["DEBUG_FLOAT_ARRAY_data_"..i], tvbrange)
    end
end
-- dissect payload of message type TUNNEL
function payload_fns.payload_385(buffer, tree, msgid, offset, limit, pinfo)
    local padded, field_offset, value, subtree, tvbrange
    if (offset + 133 > limit) then
        padded = buffer(0, limit):bytes()
        padded:set_size(offset + 133)
        padded = padded:tvb("Untruncated payload")
    else
        padded = buffer
    end
    tvbrange = padded(offset + 2, 1)
    subtree = tree:add_le(f.TUNNEL_target_system, tvbrange)
    tvbrange = padded(offset + 3, 1)
    subtree = tree:add_le(f.TUNNEL_target_component, tvbrange)
    tvbrange = padded(offset + 0, 2)
    subtree = tree:add_le(f.TUNNEL_payload_type, tvbrange)
    tvbrange = padded(offset + 4, 1)
    subtree = tree:add_le(f.TUNNEL_payload_length, tvbrange)
    for i = 0, 127 do
        tvbrange = padded(offset + 5 + 1 * i, 1)
        subtree = tree:add_le(f["TUNNEL_payload_"..i], tvbrange)
    end
end
-- dissect payload of message type ONBOARD_COMPUTER_STATUS
function payload_fns.payload_390(buffer, tree, msgid, offset, limit, pinfo)
    local padded, field_offset, value, subtree, tvbrange
    if (offset + 240 > limit) then
        padded = buffer(0, limit):bytes()
        padded:set_size(offset + 240)
        padded = padded:tvb("Untruncated payload")
    else
        padded = buffer
    end
    tvbrange = padded(offset + 0, 8)
    subtree = tree:add_le(f.ONBOARD_COMPUTER_STATUS_time_usec, tvbrange)
    value = tvbrange:le_uint64()
    subtree:append_text(time_usec_decode(value))
    tvbrange = padded(offset + 8, 4)
    subtree = tree:add_le(f.ONBOARD_COMPUTER_STATUS_uptime, tvbrange)
    tvbrange = padded(offset + 196, 1)
    subtree = tree:add_le(f.ONBOARD_COMPUTER_STATUS_type, tvbrange)
    for i = 0, 7 do
        tvbrange = padded(offset + 197 + 1 * i, 1)
        subtree = tree:add_le(f["ONBOARD_COMPUTER_STATUS_cpu_cores_"..i], tvbrange)
    end
    for i = 0, 9 do
        tvbrange = padded(offset + 205 + 1 * i, 1)
        subtree = tree:add_le(f["ONBOARD_COMPUTER_STATUS_cpu_combined_"..i], tvbrange)
    end
    for i = 0, 3 do
        tvbrange = padded(offset + 215 + 1 * i, 1)
        subtree = tree:add_le(f["ONBOARD_COMPUTER_STATUS_gpu_cores_"..i], tvbrange)
    end
    for i = 0, 9 do
        tvbrange = padded(offset + 219 + 1 * i, 1)
        subtree = tree:add_le(f["ONBOARD_COMPUTER_STATUS_gpu_combined_"..i], tvbrange)
    end
    tvbrange = padded(offset + 229, 1)
    subtree = tree:add_le(f.ONBOARD_COMPUTER_STATUS_temperature_board, tvbrange)
    for i = 0, 7 do
        tvbrange = padded(offset + 230 + 1 * i, 1)
        subtree = tree:add_le(f["ONBOARD_COMPUTER_STATUS_temperature_core_"..i], tvbrange)
    end
    for i = 0, 3 do
        tvbrange = padded(offset + 188 + 2 * i, 2)
        subtree = tree:add_le(f["ONBOARD_COMPUTER_STATUS_fan_speed_"..i], tvbrange)
    end
    tvbrange = padded(offset + 12, 4)
    subtree = tree:add_le(f.ONBOARD_COMPUTER_STATUS_ram_usage, tvbrange)
    tvbrange = padded(offset + 16, 4)
    subtree = tree:add_le(f.ONBOARD_COMPUTER_STATUS_ram_total, tvbrange)
    for i = 0, 3 do
        tvbrange = padded(offset + 20 + 4 * i, 4)
        subtree = tree:add_le(f["ONBOARD_COMPUTER_STATUS_storage_type_"..i], tvbrange)
    end
    for i = 0, 3 do
        tvbrange = padded(offset + 36 + 4 * i, 4)
        subtree = tree:add_le(f["ONBOARD_COMPUTER_STATUS_storage_usage_"..i], tvbrange)
    end
    for i = 0, 3 do
        tvbrange = padded(offset + 52 + 4 * i, 4)
        subtree = tree:add_le(f["ONBOARD_COMPUTER_STATUS_storage_total_"..i], tvbrange)
    end
    for i = 0, 5 do
        tvbrange = padded(offset + 68 + 4 * i, 4)
        subtree = tree:add_le(f["ONBOARD_COMPUTER_STATUS_link_type_"..i], tvbrange)
    end
    for i = 0, 5 do
        tvbrange = padded(offset + 92 + 4 * i, 4)
        subtree = tree:add_le(f["ONBOARD_COMPUTER_STATUS_link_tx_rate_"..i], tvbrange)
    end
    for i = 0, 5 do
        tvbrange = padded(offset + 116 + 4 * i, 4)
        subtree = tree:add_le(f["ONBOARD_COMPUTER_STATUS_link_rx_rate_"..i], tvbrange)
    end
    for i = 0, 5 do
        tvbrange = padded(offset + 140 + 4 * i, 4)
        subtree = tree:add_le(f["ONBOARD_COMPUTER_STATUS_link_tx_max_"..i], tvbrange)
    end
    for i = 0, 5 do
        tvbrange = padded(offset + 164 + 4 * i, 4)
        subtree = tree:add_le(f["ONBOARD_COMPUTER_STATUS_link_rx_max_"..i], tvbrange)
    end
    tvbrange = padded(offset + 238, 2)
    subtree = tree:add_le(f.ONBOARD_COMPUTER_STATUS_status_flags, tvbrange)
    value = tvbrange:le_uint()
    dissect_flags_COMPUTER_STATUS_FLAGS(subtree, "ONBOARD_COMPUTER_STATUS_status_flags", tvbrange, value)
end
-- dissector function
function mavlink_proto.dissector(buffer,pinfo,tree)
    local offset = 0
    local msgCount = 0

    -- loop through the buffer to extract all the messages in the buffer
    while (offset < buffer:len())
    do
        msgCount = msgCount + 1
        local subtree = tree:add (mavlink_proto, buffer(), "MAVLink Protocol ("..buffer:len()..")")

        -- decode protocol version first
        local version = buffer(offset,1):uint()
        local protocolString = ""

        while (true)
        do
            protocolString = protocolVersions[version]
            if (protocolString ~= nil) then
                break
            else
                protocolString = "unknown"
                -- some unknown data found, record the begin offset
                if (unknownFrameBeginOffset == 0) then
                    unknownFrameBeginOffset = offset
                end

                offset = offset + 1

                if (offset < buffer:len()) then
                    version = buffer(offset,1):uint()
                else
                    -- no magic value found in the whole buffer. print the raw data and exit
                    if (unknownFrameBeginOffset ~= 0) then
                        if (msgCount == 1) then
                            pinfo.cols.info:set("Unknown message")
                        else
                            pinfo.cols.info:append("  Unknown message")
                        end
                        size = offset - unknownFrameBeginOffset
                        subtree:add(f.rawpayload, buffer(unknownFrameBeginOffset,size))
                        unknownFrameBeginOffset = 0
                    end
                    return
                end
            end
        end

        if (unknownFrameBeginOffset ~= 0) then
            pinfo.cols.info:append("Unknown message")
            size = offset - unknownFrameBeginOffset
            subtree:add(f.rawpayload, buffer(unknownFrameBeginOffset,size))
            unknownFrameBeginOffset = 0
            -- jump to next loop
            break
        end

        -- some Wireshark decoration
        pinfo.cols.protocol = protocolString

        -- HEADER ----------------------------------------

        local msgid
        local length
        local incompatibility_flag

        local here = buffer:len() - offset
        local least = version == 0xfd and 12 or 8
        if here < least or here < least + buffer(offset + 1, 1):uint() then
            subtree:add_expert_info(PI_UNDECODED, PI_NOTE, "The rest of this frame is not here")
            break
        end

        if (version == 0xfe) then
            if (buffer:len() - 2 - offset > 6) then
                -- normal header
                local header = subtree:add(buffer(offset, 6), "Header")
                header:add(f.magic, buffer(offset,1), version)
                offset = offset + 1

                length = buffer(offset,1)
                header:add(f.length, length)
                offset = offset + 1

                local sequence = buffer(offset,1)
                header:add(f.sequence, sequence)
                offset = offset + 1

                local sysid = buffer(offset,1)
                header:add(f.sysid, sysid)
                offset = offset + 1

                local compid = buffer(offset,1)
                header:add(f.compid, compid)
                offset = offset + 1

                pinfo.cols.src = "System: "..tostring(sysid:uint())..', Component: '..tostring(compid:uint())

                msgid = buffer(offset,1):uint()
                header:add(f.msgid, buffer(offset,1), msgid)
                offset = offset + 1
            else
                -- handle truncated header
                local hsize = buffer:len() - 2 - offset
                subtree:add(f.rawheader, buffer(offset, hsize))
                offset = offset + hsize
            end
        elseif (version == 0xfd) then
            if (buffer:len() - 2 - offset > 10) then
                -- normal header
                local header = subtree:add(buffer(offset, 10), "Header")
                header:add(f.magic, buffer(offset,1), version)
                offset = offset + 1
                length = buffer(offset,1)
                header:add(f.length, length)
                offset = offset + 1
                incompatibility_flag = buffer(offset,1):uint()
                header:add(f.incompatibility_flag, buffer(offset,1), incompatibility_flag)
                offset = offset + 1
                local compatibility_flag = buffer(offset,1)
                header:add(f.compatibility_flag, compatibility_flag)
                offset = offset + 1
                local sequence = buffer(offset,1)
                header:add(f.sequence, sequence)
                offset = offset + 1
                local sysid = buffer(offset,1)
                header:add(f.sysid, sysid)
                offset = offset + 1
                local compid = buffer(offset,1)
                header:add(f.compid, compid)
                offset = offset + 1
                pinfo.cols.src = "System: "..tostring(sysid:uint())..', Component: '..tostring(compid:uint())
                msgid = buffer(offset,3):le_uint()
                header:add(f.msgid, buffer(offset,3), msgid)
                offset = offset + 3
            else
                -- handle truncated header
                local hsize = buffer:len() - 2 - offset
                subtree:add(f.rawheader, buffer(offset, hsize))
                offset = offset + hsize
            end
        end


        -- BODY ----------------------------------------

        -- dynamically call the type-specific payload dissector
        local msgnr = msgid
        local dissect_payload_fn = "payload_"..tostring(msgnr)
        local fn = payload_fns[dissect_payload_fn]
        local limit = buffer:len() - 2

        if (length) then
            length = length:uint()
        else
            length = 0
        end

        if (offset + length < limit) then
            limit = offset + length
        end

        if (fn == nil) then
            pinfo.cols.info:append ("   message "..tostring(msgid))
            subtree:add_expert_info(PI_UNDECODED, PI_NOTE, "A message of another dialect")
            size = limit - offset
            subtree:add(f.rawpayload, buffer(offset,size))
            offset = offset + size
        else
            local payload = subtree:add(f.payload, buffer(offset, limit - offset), msgid)
            pinfo.cols.dst:set(messageName[msgid])
            if (msgCount == 1) then
            -- first message should over write the TCP/UDP info
                pinfo.cols.info = messageName[msgid]
            else
                pinfo.cols.info:append("   "..messageName[msgid])
            end
            fn(buffer, payload, msgid, offset, limit, pinfo)
            offset = limit
        end

        -- CRC ----------------------------------------

        local crc = buffer(offset,2)
        subtree:add_le(f.crc, crc)
        offset = offset + 2

        -- SIGNATURE ----------------------------------

        if (version == 0xfd and bit.band(incompatibility_flag, 0x01) ~= 0) then
            if (offset + 13 <= buffer:len()) then
                local signature = subtree:add("Signature")

                local link = buffer(offset,1)
                signature:add(f.signature_link, link)
                offset = offset + 1

                local signature_time = buffer(offset,6):le_uint64()
                local time_secs = signature_time / 100000
                local time_nsecs = (signature_time - (time_secs * 100000)) * 10000
                signature:add(f.signature_time, buffer(offset,6), NSTime.new(signature_time_ref + time_secs:tonumber(), time_nsecs:tonumber()))
                offset = offset + 6

                local signature_signature = buffer(offset,6)
                signature:add(f.signature_signature, signature_signature)
                offset = offset + 6
            end
        end

    end
end



-- what a TUNNEL of type ROSS_TUNNEL_TYPE_FRAME carries is a frame too
local dissect_tunnel = payload_fns.payload_385
payload_fns.payload_385 = function (buffer, tree, msgid, offset, limit, pinfo)
    local bytes = buffer:range(offset, limit - offset):bytes()
    bytes:set_size(133)
    local whole = bytes:tvb("TUNNEL")
    local length = whole:range(4, 1):uint()
    if whole:range(0, 2):le_uint() ~= 54000 or length == 0 or length > 133 - 5 then
        return dissect_tunnel(buffer, tree, msgid, offset, limit, pinfo)
    end
    tree:add_le(f.TUNNEL_payload_type, whole:range(0, 2))
    tree:add_le(f.TUNNEL_target_system, whole:range(2, 1))
    tree:add_le(f.TUNNEL_target_component, whole:range(3, 1))
    tree:add_le(f.TUNNEL_payload_length, whole:range(4, 1))
    mavlink_proto.dissector(bytes:subset(5, length):tvb("Frame in the TUNNEL"), pinfo, tree)
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

-- bind protocol dissector to USER0 linktype

wtap_encap = DissectorTable.get("wtap_encap")
wtap_encap:add(wtap.USER0, mavlink_proto)

-- bind protocol dissector to ports: 14550, 14580, 18570

local udp_dissector_table = DissectorTable.get("udp.port")
udp_dissector_table:add(14550, mavlink_proto)
udp_dissector_table:add(14580, mavlink_proto)
udp_dissector_table:add(18570, mavlink_proto)

-- register common Mavlink TCP ports

DissectorTable.get("tcp.port"):add("5760-5763", mavlink_proto)
