-- What Wireshark shows of packets: the protocol's fields and faults, by the names that filters have.

local lum = Proto("lum", "Luminar Model G2")

local type_names = {
    [tables.types.set_ip] = "set IP",
    [tables.types.timestamp] = "timestamp",
    [tables.types.tlv] = "TLV",
    [tables.types.heartbeat] = "heartbeat or data",
}
local tag_names = {[tables.tags.angles] = "angles", [tables.tags.ranges] = "ranges"}

-- Fields ----------------------------------------------------------------------

local f = {
    kind = ProtoField.string("lum.kind", "Kind", base.ASCII, "As lumdump counts it"),
    magic = ProtoField.bytes("lum.magic", "Magic"),
    type = ProtoField.uint8("lum.type", "Type", base.DEC, type_names),
    reserved = ProtoField.bytes("lum.reserved", "Reserved"),
    rest = ProtoField.bytes("lum.rest", "Bytes after the packet's end"),
    request = ProtoField.framenum("lum.request_frame", "Request in", base.NONE, frametype.REQUEST),
    answer = ProtoField.framenum("lum.answer_frame", "Answer in", base.NONE, frametype.RESPONSE),
    joined = ProtoField.uint32("lum.joined", "Datagrams that were joined"),
    answer_time = ProtoField.double("lum.answer_time", "Answered after (s)"),

    set_ip = ProtoField.ipv4("lum.set_ip.address", "New address"),
    set_ip_other = ProtoField.ipv4("lum.set_ip.reversed", "In the other byte order"),

    time_sequence = ProtoField.uint32("lum.timestamp.sequence", "Sequence"),
    time_clock = ProtoField.uint32("lum.timestamp.clock", "Sensor clock (us)"),

    tlv_sequence = ProtoField.uint32("lum.tlv.sequence", "Sequence"),
    tlv = ProtoField.none("lum.tlv", "TLV"),
    tlv_type = ProtoField.uint16("lum.tlv.type", "Type"),
    tlv_length = ProtoField.uint16("lum.tlv.length", "Length"),
    tlv_value = ProtoField.bytes("lum.tlv.value", "Value"),
    command_text = ProtoField.string("lum.tlv.command", "Commands"),
    command = ProtoField.string("lum.command", "Command"),
    command_name = ProtoField.string("lum.command.name", "Name"),
    command_value = ProtoField.uint32("lum.command.value", "Value"),
    debug = ProtoField.string("lum.tlv.debug", "Debug text"),
    status = ProtoField.uint16("lum.laser.status", "Laser status", base.HEX),
    laser_down = ProtoField.bool("lum.laser.down", "Laser is down"),
    laser_hazard = ProtoField.bool("lum.laser.hazard", "Hazard"),
    yscan_lines = ProtoField.uint32("lum.yscan.lines", "Lines"),
    yscan_raw = ProtoField.int16("lum.yscan.raw", "Elevation, raw"),
    yscan_elevation = ProtoField.double("lum.yscan.elevation", "Elevation (degrees)"),

    tag = ProtoField.uint32("lum.data.tag", "Tag", base.DEC, tag_names),
    eye = ProtoField.string("lum.data.eye", "Eye"),
    eye_value = ProtoField.uint32("lum.data.eye_value", "On the wire"),
    line = ProtoField.uint32("lum.data.line", "Line"),
    num_samples = ProtoField.uint32("lum.data.num_samples", "Samples"),
    first_sample_index = ProtoField.uint32("lum.data.first_sample_index", "Index of the first sample"),
    timestamp = ProtoField.uint64("lum.data.timestamp", "Sensor clock (ticks)"),
    bad_words = ProtoField.uint32("lum.data.bad_words", "Bad words"),
    missing = ProtoField.uint32("lum.data.missing", "Samples of the line not seen before this packet"),
    samples = ProtoField.bytes("lum.data.samples", "Samples"),

    angle = ProtoField.none("lum.angle", "Angles"),
    angle_pixel = ProtoField.uint32("lum.angle.pixel", "Pixel"),
    azimuth_raw = ProtoField.int16("lum.angle.azimuth_raw", "Azimuth, raw"),
    azimuth = ProtoField.double("lum.angle.azimuth", "Azimuth (degrees)"),
    elevation_raw = ProtoField.int16("lum.angle.elevation_raw", "Elevation, raw"),
    elevation = ProtoField.double("lum.angle.elevation", "Elevation (degrees)"),

    word = ProtoField.uint32("lum.word", "Word", base.HEX),
    tof = ProtoField.int32("lum.word.tof", "Time of flight", base.DEC, nil, 0xfffff000),
    zero = ProtoField.bool("lum.word.zero", "Bit that is zero", 32, nil, tables.word.zero),
    rising = ProtoField.bool("lum.word.rising", "Rising edge", 32, nil, tables.word.rising),
    pixel = ProtoField.uint32("lum.word.pixel", "Pixel", base.DEC, nil, tables.word.pixel),
    return_number = ProtoField.uint32("lum.word.return", "Return"),
    range = ProtoField.double("lum.word.range", "Range (m)"),
}
for _, bit in ipairs(tables.laser.bits) do
    f[bit.name] = ProtoField.bool("lum.laser." .. bit.name:lower(), bit.name, 16, nil, bit.mask)
end

-- Faults: what docs/protocol.md rejects, each by its name ---------------------

local MALFORMED, PROTOCOL, RESPONSE, SEQUENCE, UNDECODED =
    expert.group.MALFORMED, expert.group.PROTOCOL, expert.group.RESPONSE_CODE,
    expert.group.SEQUENCE, expert.group.UNDECODED
local ERROR, WARN, NOTE, CHAT =
    expert.severity.ERROR, expert.severity.WARN, expert.severity.NOTE, expert.severity.CHAT

local fault_list = {
    -- name, text, group, severity
    {"short", "shorter than a header", UNDECODED, NOTE},
    {"magic", "without our magic", UNDECODED, NOTE},
    {"reserved", "a reserved byte is not 0", UNDECODED, WARN},
    {"type", "type that is not known", UNDECODED, WARN},
    {"set_ip_short", "set IP packet shorter than " .. tables.bytes.set_ip .. " bytes", MALFORMED, ERROR},
    {"timestamp_short", "timestamp packet shorter than " .. tables.bytes.timestamp .. " bytes", MALFORMED, ERROR},
    {"tlv_short", "TLV packet shorter than " .. tables.bytes.tlv .. " bytes", MALFORMED, ERROR},
    {"data_short", "data packet shorter than the offset of its samples", MALFORMED, ERROR},
    {"no_samples", "num_samples is 0", MALFORMED, ERROR},
    {"wide", "a line, num_samples or first_sample_index above 4294967295", MALFORMED, ERROR},
    {"samples_short", "data packet shorter than its samples", MALFORMED, ERROR},
    {"eye", "the eye is neither of the two values", MALFORMED, ERROR},
    {"tag", "the tag is neither angles nor ranges", UNDECODED, WARN},
    {"angles_past_end", "angles past the last pixel of a line", MALFORMED, ERROR},
    {"word_zero", "bad word: bit 11 is set", MALFORMED, WARN},
    {"word_pixel", "bad word: pixel above " .. tables.line_pixels - 1, MALFORMED, WARN},
    {"bad_words", "words with an impossible bit or pixel", MALFORMED, WARN},
    {"address", "not the address of a host", PROTOCOL, WARN},
    {"tlv_head", "fewer bytes are left than the head of a TLV has", MALFORMED, ERROR},
    {"tlv_overrun", "the TLV announces more bytes than are left", MALFORMED, ERROR},
    {"tlv_type", "TLV of a type that is not known", UNDECODED, NOTE},
    {"status_short", "status shorter than two bytes", MALFORMED, ERROR},
    {"status_long", "status longer than two bytes", PROTOCOL, NOTE},
    {"yscan_odd", "Y-scan table with an odd number of bytes", MALFORMED, ERROR},
    {"command", "not a command of the manual", MALFORMED, ERROR},
    {"command_value", "value that the command does not allow", MALFORMED, ERROR},
    {"hazard", "the laser is down for a hazard", RESPONSE, WARN},
    {"rest", "bytes after the packet's end are ignored", PROTOCOL, NOTE},
    {"missing", "samples of this line lost, or not yet here", SEQUENCE, NOTE},
    {"repeated", "sequence number used again", SEQUENCE, NOTE},
    {"unasked", "answer to no request of this capture", SEQUENCE, CHAT},
    {"unanswered", "no answer in this capture", SEQUENCE, NOTE},
    {"cut_short", "the capture holds only a part of the datagram", UNDECODED, WARN},
    {"length", "UDP length beyond the IP payload", MALFORMED, WARN},
    {"not_ipv4", "not over IPv4", UNDECODED, NOTE},
    {"layout", "the preference \"layout\" is not understood", UNDECODED, ERROR},
}
local fault_texts, experts = {}, {}
for _, row in ipairs(fault_list) do
    local name, text, group, severity = row[1], row[2], row[3], row[4]
    fault_texts[name], experts[name] = text, ProtoExpert.new("lum.fault." .. name, text, group, severity)
end
lum.fields, lum.experts = f, experts

-- add_fault(ITEM, NAME [, DETAIL])
local function add_fault(item, name, detail)
    local text = fault_texts[name]
    item:add_proto_expert_info(experts[name], detail and text .. ": " .. detail or text)
end

-- Bytes behind the end of a packet.
local function add_rest(tree, tvb, from)
    if tvb:len() > from then
        add_fault(tree:add(f.rest, tvb(from)), "rest")
    end
end

-- The info column of a packet that is rejected.
local function rejected_info(kind, fault)
    return kind:gsub("_", " "):gsub("^%l", string.upper) .. ": " .. fault_texts[fault]
end

return {proto = lum, f = f, tag_names = tag_names, add_fault = add_fault, add_rest = add_rest, rejected_info = rejected_info}
