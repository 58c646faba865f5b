-- Packets of the Luminar Model G2 in Wireshark. What the packets are:
-- docs/protocol.md; how this is installed and used: docs/wireshark.md.
--
-- `tables` above is the C code's. Only arithmetic that Lua 5.1 to 5.4 share is
-- used: Wireshark has had several of them.

local lum = Proto("lum", "Luminar Model G2")

local TYPE_AT = tables.type_at
local HEADER = tables.header_bytes
local BODY = HEADER -- what follows the header of set IP, timestamp and TLV
local UDP_BYTES = 8
local DEFAULT_SAMPLES = 400

-- Names ----------------------------------------------------------------------

local type_names = {
    [tables.types.set_ip] = "set IP",
    [tables.types.timestamp] = "timestamp",
    [tables.types.tlv] = "TLV",
    [tables.types.heartbeat] = "heartbeat or data",
}
local tag_names = {[tables.tags.angles] = "angles", [tables.tags.ranges] = "ranges"}
local tlv_names = {} -- by the layout
local eye_names = {} -- by the layout

-- Fields ---------------------------------------------------------------------

local f = {
    kind = ProtoField.string("lum.kind", "Kind", base.ASCII, "As lumdump counts it"),
    magic = ProtoField.bytes("lum.magic", "Magic"),
    type = ProtoField.uint8("lum.type", "Type", base.DEC, type_names),
    reserved = ProtoField.bytes("lum.reserved", "Reserved"),
    rest = ProtoField.bytes("lum.rest", "Bytes after the packet's end"),
    request = ProtoField.framenum("lum.request_frame", "Request in", base.NONE, frametype.REQUEST),
    answer = ProtoField.framenum("lum.answer_frame", "Answer in", base.NONE, frametype.RESPONSE),
    fragments = ProtoField.uint32("lum.fragments", "Fragments of the datagram"),
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
local bit_fields = {}
for i, bit in ipairs(tables.laser.bits) do
    bit_fields[i] = ProtoField.bool("lum.laser." .. bit.name:lower(), bit.name, 16, nil, bit.mask)
end

local sample_fields = {f.angle, f.angle_pixel, f.azimuth_raw, f.azimuth, f.elevation_raw, f.elevation, f.word, f.tof,
                       f.zero, f.rising, f.pixel, f.return_number, f.range}

-- Faults: what docs/protocol.md rejects, each by its name --------------------

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
    {"bad_words", "words with a bit or pixel that cannot be", MALFORMED, WARN},
    {"address", "not the address of a host", PROTOCOL, WARN},
    {"tlv_head", "fewer bytes are left than the head of a TLV has", MALFORMED, ERROR},
    {"tlv_overrun", "the TLV announces more bytes than are left", MALFORMED, ERROR},
    {"tlv_type", "TLV of a type that is not known", UNDECODED, NOTE},
    {"status_short", "status shorter than two bytes", MALFORMED, ERROR},
    {"status_long", "status longer than two bytes", PROTOCOL, NOTE},
    {"yscan_odd", "Y-scan table with an odd number of bytes", MALFORMED, ERROR},
    {"command", "no command of the table", MALFORMED, ERROR},
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
local faults, experts = {}, {}
for _, row in ipairs(fault_list) do
    local name, text, group, severity = row[1], row[2], row[3], row[4]
    faults[name] = {text = text, expert = ProtoExpert.new("lum.fault." .. name, text, group, severity)}
    experts[#experts + 1] = faults[name].expert
end

-- add_fault(ITEM, NAME [, DETAIL])
local function add_fault(item, name, detail)
    local fault = faults[name]
    local text = detail and (fault.text .. ": " .. detail) or fault.text
    item:add_proto_expert_info(fault.expert, text)
end

local all_fields = {}
for _, field in pairs(f) do
    all_fields[#all_fields + 1] = field
end
for _, field in ipairs(bit_fields) do
    all_fields[#all_fields + 1] = field
end
lum.fields = all_fields
lum.experts = experts

-- Preferences and the layout -------------------------------------------------

lum.prefs.ports = Pref.range("UDP ports", tostring(tables.port), "Ports of sensors", 65535)
lum.prefs.samples = Pref.uint("Samples in the tree", DEFAULT_SAMPLES,
                              "Show at most so many samples of a data packet; 0 shows none")
lum.prefs.layout = Pref.string("Layout", "",
                               "Keys of a wire profile that differ from the default, such as: "
                               .. "tag=13 eye=12/1 line=16/2/big/0-14 samples=28 blue=66 green=71 "
                               .. "angle_order=elevation_azimuth")

local layout        -- what the decoders go by
local layout_fault  -- the word of the preference that was not understood

local function copy(value)
    if type(value) ~= "table" then
        return value
    end
    local out = {}
    for k, v in pairs(value) do
        out[k] = copy(v)
    end
    return out
end

local function whole_number(text, max)
    local n = text:match("^%d+$") and tonumber(text)
    return n and n <= max and n or nil
end

local function set_bits(field, text)
    local low, high = text:match("^(%d+)-(%d+)$")
    low, high = tonumber(low), tonumber(high)
    if not low or high < low then
        return false
    end
    field.low, field.bits = low, high - low + 1
    return true
end

-- A part behind a field's offset: its bytes, its order or its bits.
local function set_part(field, text)
    if text:match("^[1248]$") then
        field.bytes = tonumber(text)
    elseif text == "little" or text == "big" then
        field.order = text
    else
        return set_bits(field, text)
    end
    return true
end

-- A field: OFFSET[/BYTES][/ORDER][/LOW-HIGH], or none for the timestamp and the count.
local function set_field(l, key, text)
    local field = l.group[key]
    if text == "none" and (key == "timestamp" or key == "num_samples") then
        field.bytes = 0
        return true
    end
    local at, parts = text:match("^(%d+)(.*)$")
    at = at and whole_number(at, 64)
    if not at or at < 8 or parts:gsub("/[^/]+", "") ~= "" then
        return false
    end
    field.at = at
    for part in parts:gmatch("/([^/]+)") do
        if not set_part(field, part) then
            return false
        end
    end
    return field.low + field.bits <= 8 * field.bytes
end

local words = {
    set_ip_order = {network = true, little = true},
    angle_order = {azimuth_elevation = true, elevation_azimuth = true},
    sample_order = {little = true, big = true},
}

local function set_number(part, key, text, max)
    local n = whole_number(text, max)
    if n then
        part[key] = n
    end
    return n ~= nil
end

local function set_key(l, key, text)
    if l.group[key] then
        return set_field(l, key, text)
    elseif l.eye_values[key] then
        return set_number(l.eye_values, key, text, 0xffffffff)
    elseif l.tlv[key] then
        return set_number(l.tlv, key, text, 0xffff)
    elseif key == "data_packet_type" then
        return set_number(l, key, text, 255)
    elseif key == "unit_ns" then
        return set_number(l, key, text, 1000000000) and l.unit_ns > 0
    elseif key == "samples" then
        return set_number(l, key, text, 64)
    elseif words[key] and words[key][text] then
        l[key] = text
        return true
    end
    local lsb = key == "angle_lsb_deg" and tonumber(text)
    if lsb and lsb > 0 and lsb <= 1 then
        l.angle_lsb_pdeg = lsb * 1e12
        return true
    end
    return false
end

local function samples_follow(l)
    for _, field in pairs(l.group) do
        if field.bytes > 0 and field.at + field.bytes > l.samples then
            return false
        end
    end
    return true
end

-- The layout of a preference, and the first word that is not one.
local function read_layout(text)
    local l = copy(tables.profile)
    for word in text:gmatch("%S+") do
        local key, value = word:match("^([%w_]+)[=:](%S+)$")
        if not key or not set_key(l, key, value) then
            return copy(tables.profile), word
        end
    end
    if not samples_follow(l) then
        return copy(tables.profile), "samples do not follow every field"
    end
    return l, nil
end

local function clear(t)
    for k in pairs(t) do
        t[k] = nil
    end
end

local function take_layout()
    layout, layout_fault = read_layout(lum.prefs.layout or "")
    clear(eye_names)
    for name, value in pairs(layout.eye_values) do
        eye_names[value] = name
    end
    clear(tlv_names)
    for name, number in pairs(layout.tlv) do
        tlv_names[number] = name
    end
end
take_layout()

local port_text, port_ranges = nil, {}

local function is_our_port(port)
    local text = tostring(lum.prefs.ports)
    if text ~= port_text then
        port_text, port_ranges = text, {}
        for first, final in text:gmatch("(%d+)%-?(%d*)") do
            port_ranges[#port_ranges + 1] = {tonumber(first), tonumber(final) or tonumber(first)}
        end
    end
    for _, range in ipairs(port_ranges) do
        if port >= range[1] and port <= range[2] then
            return true
        end
    end
    return false
end

-- Numbers --------------------------------------------------------------------

local function has_bits(value, mask)
    return math.floor(value / mask) % 2 == 1
end

local function any_bit(value, mask)
    for _, bit in ipairs(tables.laser.bits) do
        if has_bits(mask, bit.mask) and has_bits(value, bit.mask) then
            return true
        end
    end
    return false
end

local function signed16(value)
    return value < 32768 and value or value - 65536
end

local function tof_of(word)
    local tof = math.floor(word / 4096)
    return tof <= tables.word.tof_max and tof or tof - 1048576
end

local function pixel_of(word)
    return word % (tables.word.pixel + 1)
end

-- Degrees of a raw value, by the default calibration (docs/protocol.md, 7).
local function degrees(raw, min, max)
    local center = (min + max) / 2
    if layout.angle_lsb_pdeg > 0 then
        return center / 1e6 + raw * layout.angle_lsb_pdeg * 1e-12
    end
    return (center + raw / 32768 * (max - min) / 2) / 1e6
end

local function azimuth_of(raw, eye)
    local c = tables.calibration[eye]
    return degrees(raw, c.azimuth_center_udeg - c.azimuth_width_udeg / 2,
                   c.azimuth_center_udeg + c.azimuth_width_udeg / 2)
end

local function elevation_of(raw, eye)
    local c = tables.calibration[eye]
    return degrees(raw, c.elevation_min_udeg, c.elevation_max_udeg)
end

local function range_of(tof, eye)
    local c = tables.calibration
    local fs = tof * c.tof_lsb_fs + c[eye].tof_offset_fs
    return fs * 1e-15 * c.speed_of_light / 2
end

-- Bytes as text, with what cannot be shown as \xNN.
local function printable(bytes)
    return (bytes:gsub("[^\32-\126]", function(c)
        return string.format("\\x%02x", c:byte())
    end))
end

local function text_of(tvb, at, length)
    return length > 0 and tvb:raw(at, length) or ""
end

-- What a datagram is: lum_packet_decode() in Lua -----------------------------

-- The value of a field, as 64 bits.
local function load_field(tvb, field)
    if field.bytes == 0 then
        return UInt64(0)
    end
    local range = tvb(field.at, field.bytes)
    local value = field.order == "little" and range:le_uint64() or range:uint64()
    local bits = field.bits > 0 and field.bits or 8 * field.bytes
    return value:lshift(64 - field.low - bits):rshift(64 - bits)
end

local wide_fields = {"eye", "line", "num_samples", "first_sample_index"}

local function is_wide(group)
    for _, name in ipairs(wide_fields) do
        if group[name] > 0xffffffff then
            return true
        end
    end
    return false
end

local function is_data_type(number)
    if layout.group.tag.at < HEADER then
        return tag_names[number] ~= nil
    end
    return number == layout.data_packet_type
end

local function angles_end_in_line(group)
    return group.first_sample_index + group.num_samples <= tables.line_pixels
end

local function read_group(tvb)
    local group = {}
    for name, field in pairs(layout.group) do
        local value = load_field(tvb, field)
        group[name] = name == "timestamp" and value or value:tonumber()
    end
    if layout.group.num_samples.bytes == 0 then
        group.num_samples = math.floor((tvb:len() - layout.samples) / tables.sample_bytes)
    end
    group.eye_name = eye_names[group.eye]
    group.tag_name = tag_names[group.tag]
    return group
end

-- The kind of a data packet, the fault, what was read of it.
local function classify_data(tvb)
    local length = tvb:len()
    if length < layout.samples then
        return "malformed", "data_short"
    end
    local group = read_group(tvb)
    local room = math.floor((length - layout.samples) / tables.sample_bytes)
    if group.num_samples == 0 then
        return "malformed", "no_samples", group
    elseif is_wide(group) and group.eye <= 0xffffffff then
        return "malformed", "wide", group
    elseif group.num_samples > room then
        return "malformed", "samples_short", group
    elseif not group.eye_name then
        return "malformed", "eye", group
    elseif not group.tag_name then
        return "unknown_tag", "tag", group
    elseif group.tag == tables.tags.angles and not angles_end_in_line(group) then
        return "malformed", "angles_past_end", group
    end
    return "data", nil, group
end

local names_by_type = {}
for _, name in ipairs({"set_ip", "timestamp", "tlv"}) do
    names_by_type[tables.types[name]] = name
end

local function header_fault(tvb)
    if tvb:len() < HEADER then
        return "foreign", "short"
    elseif tvb(0, TYPE_AT):bytes():tohex(true) ~= tables.magic then
        return "foreign", "magic"
    elseif tvb(TYPE_AT + 1, HEADER - TYPE_AT - 1):uint() ~= 0 then
        return "unknown_type", "reserved"
    end
    return nil
end

local function classify(tvb)
    local kind, fault = header_fault(tvb)
    if kind then
        return tables.kinds[kind], fault
    end
    local number = tvb(TYPE_AT, 1):uint()
    local name = names_by_type[number]
    if number == tables.types.heartbeat and tvb:len() == tables.bytes.heartbeat then
        return tables.kinds.heartbeat
    elseif is_data_type(number) then
        local data_kind, data_fault, group = classify_data(tvb)
        return tables.kinds[data_kind], data_fault, group
    elseif not name then
        return tables.kinds.unknown_type, "type"
    elseif tvb:len() < tables.bytes[name] then
        return tables.kinds.malformed, name .. "_short"
    end
    return tables.kinds[name]
end

-- How the datagram came here (docs/protocol.md, 9) ---------------------------

local frame_length = Field.new("frame.len")
local ip_version = Field.new("ip.version")
local ip_length = Field.new("ip.len")
local ip_header = Field.new("ip.hdr_len")
local ip_protocol = Field.new("ip.proto")
local ip_more = Field.new("ip.flags.mf")
local ip_offset = Field.new("ip.frag_offset")
local udp_length = Field.new("udp.length")

local UDP = 17

local function last(...)
    local n = select("#", ...)
    return n > 0 and (select(n, ...)).value or nil
end

-- Fields exist only where Wireshark builds a tree. Where it does not, it wants
-- no more than the columns.
local function has_tree()
    return last(frame_length()) ~= nil
end

local function is_fragment()
    local more, offset = last(ip_more()), last(ip_offset())
    return more == true or more == 1 or (offset or 0) > 0
end

-- Why a datagram is not decoded at all, if so.
local function transport_fault(tvb, pinfo)
    if not has_tree() then
        return nil
    elseif not last(ip_length()) then
        return "other", "not_ipv4"
    end
    local whole = last(ip_length()) - last(ip_header())
    local held = pinfo.caplen - (tvb:offset() - UDP_BYTES)
    if last(udp_length()) > whole then
        return "other", "length"
    elseif held < whole or tvb:len() < tvb:reported_len() then
        return "cut_short", "cut_short"
    end
    return nil
end

-- What earlier packets have told ---------------------------------------------

local requests = {} -- of a sequence number, not answered yet: frame, time
local links = {}    -- of a frame: request, answer, time
local streams = {}  -- of an eye and a tag: line and next index
local missing = {}  -- of a frame: samples that should have come before it

-- What is told of a packet's way: its ends as text, ports, frame, time. The
-- key is the frame, or one of several datagrams in it.
local function way_of(pinfo, src_port, dst_port)
    return {src = tostring(pinfo.src), dst = tostring(pinfo.dst), src_port = src_port, dst_port = dst_port,
            number = pinfo.number, key = pinfo.number, visited = pinfo.visited, time = pinfo.rel_ts, cols = pinfo.cols}
end

local function to_sensor(way)
    return is_our_port(way.dst_port) and not is_our_port(way.src_port)
end

local function ask(way, key)
    local repeats = requests[key]
    links[way.key] = {repeats = repeats and repeats.frame}
    requests[key] = repeats or {frame = way.number, key = way.key, time = way.time}
end

local function reply(way, key)
    local request = requests[key]
    requests[key] = nil
    if not request then
        links[way.key] = {unasked = true}
        return
    end
    links[way.key] = {request = request.frame, time = way.time - request.time}
    links[request.key].answer = way.number
end

-- Links requests and answers; shows what is known of this packet's.
local function follow(tree, way, kind, sequence)
    local asks = to_sensor(way)
    if not way.visited then
        local ends = asks and {way.src, way.src_port, way.dst} or {way.dst, way.dst_port, way.src}
        local key = table.concat({kind, sequence, ends[1], ends[2], ends[3]}, " ")
        if asks then
            ask(way, key)
        else
            reply(way, key)
        end
    end
    local link = links[way.key] or {}
    if link.request then
        tree:add(f.request, link.request):set_generated()
        tree:add(f.answer_time, link.time):set_generated()
    elseif link.answer then
        tree:add(f.answer, link.answer):set_generated()
    elseif link.unasked then
        add_fault(tree, "unasked")
    elseif link.repeats then
        add_fault(tree, "repeated", "first in frame " .. link.repeats)
    elseif way.visited then
        add_fault(tree, "unanswered")
    end
end

local function note_missing(way, group)
    local key = way.src .. " " .. group.eye .. " " .. group.tag
    local stream = streams[key]
    local first = group.first_sample_index
    local next_index = stream and stream.line == group.line and stream.next or 0
    if stream and first > next_index then
        missing[way.key] = first - next_index
    end
    if not stream or stream.line ~= group.line or first >= next_index or first == 0 then
        streams[key] = {line = group.line, next = first + group.num_samples}
    end
end

-- Trees ----------------------------------------------------------------------

local function show_header(tree, tvb, fault)
    if tvb:len() < HEADER then
        return
    end
    tree:add(f.magic, tvb(0, TYPE_AT))
    tree:add(f.type, tvb(TYPE_AT, 1))
    local item = tree:add(f.reserved, tvb(TYPE_AT + 1, HEADER - TYPE_AT - 1))
    if fault == "reserved" then
        add_fault(item, fault)
    end
end

local function show_rest(tree, tvb, from)
    if tvb:len() > from then
        add_fault(tree:add(f.rest, tvb(from)), "rest")
    end
end

local function show_set_ip(tree, tvb)
    local range = tvb(BODY, 4)
    local network, little = range:ipv4(), range:le_ipv4()
    local is_network = layout.set_ip_order == "network"
    local address = is_network and network or little
    local item = tree:add(f.set_ip, range, address)
    tree:add(f.set_ip_other, range, is_network and little or network):set_generated()
    local first = is_network and range(0, 1):uint() or range(3, 1):uint()
    local value = range:uint()
    if value == 0 or value == 0xffffffff or math.floor(first / 16) == 0xe then
        add_fault(item, "address")
    end
    show_rest(tree, tvb, tables.bytes.set_ip)
    return "Set IP " .. tostring(address)
end

local function show_timestamp(tree, tvb, way)
    local sequence = tvb(BODY, 4):le_uint()
    local clock = tvb(BODY + 4, 4):le_uint()
    local asks = to_sensor(way)
    tree:add_le(f.time_sequence, tvb(BODY, 4))
    local item = tree:add_le(f.time_clock, tvb(BODY + 4, 4))
    if asks then
        item:append_text(" (ignored in a request)")
    end
    follow(tree, way, "timestamp", sequence)
    show_rest(tree, tvb, tables.bytes.timestamp)
    if asks then
        return string.format("Timestamp request seq %d", sequence)
    end
    return string.format("Timestamp clock %d seq %d", clock, sequence)
end

-- lum_command_parse(): the command's row, its value and text; or a fault.
local function parse_command(text)
    local digits, letter, after = text:match("^(%d*)(.)(.*)$")
    if not letter or digits:match("^0%d") or (after ~= "" and not after:match("^ .")) then
        return nil, "command"
    end
    for _, row in ipairs(tables.commands) do
        if row.letter == letter and row.has_value == (digits ~= "") then
            local value = tonumber(digits) or 0
            if value < row.min or value > row.max or (value - row.min) % row.step ~= 0 then
                return nil, "command_value", string.format("%s takes %d to %d%s, not %s", row.name, row.min, row.max,
                                                           row.step > 1 and " in steps of " .. row.step or "", digits)
            end
            return row, value, digits .. letter
        end
    end
    return nil, "command"
end

local function show_command(tree, tvb, at, length)
    local text = text_of(tvb, at, length)
    local shown = printable(text)
    local item = tree:add(f.command_text, tvb(at, length), shown)
    if text == "" then
        add_fault(item, "command", "empty")
    end
    while text ~= "" do
        local row, value, written = parse_command(text)
        if not row then
            local found = tree:add(f.command, tvb(at, #text), printable(text))
            add_fault(found, value, written or printable(text))
            break
        end
        local sub = tree:add(f.command, tvb(at, #written), written)
        sub:add(f.command_name, tvb(at, #written), row.name)
        if row.has_value then
            sub:add(f.command_value, tvb(at, #written - 1), value)
        end
        at = at + #written + 1
        text = text:sub(#written + 2)
    end
    return "command " .. shown
end

local function status_names(status, mask)
    local names = {}
    for _, bit in ipairs(tables.laser.bits) do
        if has_bits(status, bit.mask) and has_bits(mask or 0xffff, bit.mask) then
            names[#names + 1] = bit.name
        end
    end
    return #names > 0 and table.concat(names, " ") or "no bit"
end

local function show_status(tree, tvb, at, length)
    if length < 2 then
        add_fault(tree, "status_short")
        return "status"
    end
    local range = tvb(at, 2)
    local status = range:le_uint()
    local down = any_bit(status, tables.laser.all_down)
    local hazard = any_bit(status, tables.laser.hazards)
    local item = tree:add_le(f.status, range)
    item:append_text(" (" .. status_names(status) .. ")")
    for i in ipairs(tables.laser.bits) do
        item:add_le(bit_fields[i], range)
    end
    tree:add(f.laser_down, range, down):set_generated()
    local hazard_item = tree:add(f.laser_hazard, range, hazard)
    hazard_item:set_generated()
    if hazard then
        add_fault(hazard_item, "hazard", status_names(status, tables.laser.hazards))
    end
    if length > 2 then
        add_fault(item, "status_long")
    end
    local state = down and "down" or any_bit(status, tables.laser.on) and "up" or "may be up"
    return string.format("status 0x%04x laser %s: %s", status, state, status_names(status))
end

local function show_debug(tree, tvb, at, length)
    local text = printable(text_of(tvb, at, length))
    tree:add(f.debug, tvb(at, length), text)
    return "debug \"" .. text .. "\""
end

local function show_yscan(tree, tvb, at, length)
    local lines = math.floor(length / 2)
    tree:add(f.yscan_lines, tvb(at, length), lines):set_generated()
    if length % 2 ~= 0 then
        add_fault(tree, "yscan_odd")
        return string.format("Y-scan table of %d bytes", length)
    end
    for i = 0, lines - 1 do
        local range = tvb(at + 2 * i, 2)
        local elevation = elevation_of(range:le_int(), "blue")
        local item = tree:add_le(f.yscan_raw, range)
        item:set_text(string.format("Line %d: %.4f degrees (%d)", i, elevation, range:le_int()))
        item:add(f.yscan_elevation, range, elevation):set_generated()
    end
    return string.format("Y-scan table of %d lines", lines)
end

local show_value = {command = show_command, status = show_status, debug = show_debug, yscan = show_yscan}

-- One TLV; where the next begins, and a word for the info column.
local function show_tlv(tree, tvb, at)
    local head = tables.tlv_head_bytes
    local left = tvb:len() - at
    if left < head then
        add_fault(tree:add(f.tlv, tvb(at)), "tlv_head")
        return nil, "[malformed]"
    end
    local number, length = tvb(at, 2):le_uint(), tvb(at + 2, 2):le_uint()
    local overrun = length > left - head
    local item = tree:add(f.tlv, tvb(at, overrun and left or head + length))
    local name = tlv_names[number]
    item:append_text(": " .. (name or "type " .. number))
    item:add_le(f.tlv_type, tvb(at, 2)):append_text(" (" .. (name or "not known") .. ")")
    local length_item = item:add_le(f.tlv_length, tvb(at + 2, 2))
    if overrun then
        add_fault(length_item, "tlv_overrun", string.format("%d of %d", left - head, length))
        return nil, "[malformed]"
    end
    if not name then
        add_fault(item, "tlv_type")
    end
    if not name or not show_value[name] then
        if length > 0 then
            item:add(f.tlv_value, tvb(at + head, length))
        end
        return at + head + length, string.format("type %d of %d bytes", number, length)
    end
    return at + head + length, show_value[name](item, tvb, at + head, length)
end

local function show_tlvs(tree, tvb, way)
    local at = tables.bytes.tlv
    local sequence = tvb(BODY, 4):le_uint()
    local parts = {}
    tree:add_le(f.tlv_sequence, tvb(BODY, 4))
    follow(tree, way, "tlv", sequence)
    while at and at < tvb:len() do
        local word
        at, word = show_tlv(tree, tvb, at)
        parts[#parts + 1] = word
    end
    if #parts == 0 then
        parts[1] = "asks for status"
    end
    return string.format("TLV %s seq %d", table.concat(parts, ", "), sequence)
end

-- Samples --------------------------------------------------------------------

local function angle_at(tvb, at)
    local a, b = tvb(at, 2), tvb(at + 2, 2)
    if layout.angle_order == "azimuth_elevation" then
        return a, b
    end
    return b, a
end

-- Samples are in the order of bytes that the layout says.
local function int_of(range)
    return layout.sample_order == "little" and range:le_int() or range:int()
end

local function add_sample(tree, field, range)
    return layout.sample_order == "little" and tree:add_le(field, range) or tree:add(field, range)
end

local function show_angle(tree, tvb, at, group, i)
    local azimuth_range, elevation_range = angle_at(tvb, at)
    local azimuth_raw, elevation_raw = int_of(azimuth_range), int_of(elevation_range)
    local azimuth = azimuth_of(azimuth_raw, group.eye_name)
    local elevation = elevation_of(elevation_raw, group.eye_name)
    local pixel = group.first_sample_index + i
    local item = tree:add(f.angle, tvb(at, tables.sample_bytes))
    item:set_text(string.format("Pixel %d: azimuth %.4f, elevation %.4f degrees", pixel, azimuth, elevation))
    item:add(f.angle_pixel, tvb(at, tables.sample_bytes), pixel):set_generated()
    add_sample(item, f.azimuth_raw, azimuth_range)
    item:add(f.azimuth, azimuth_range, azimuth):set_generated()
    add_sample(item, f.elevation_raw, elevation_range)
    item:add(f.elevation, elevation_range, elevation):set_generated()
end

local function word_fault(word)
    if has_bits(word, tables.word.zero) then
        return "word_zero"
    elseif pixel_of(word) >= tables.line_pixels then
        return "word_pixel"
    end
    return nil
end

-- Number of a good word among those of its pixel and edge.
local function count_return(returns, word)
    local key = word % (2 * tables.word.rising)
    returns[key] = (returns[key] or 0) + 1
    return returns[key]
end

local function show_word(tree, range, word, eye_name, fault, number)
    local tof, rising = tof_of(word), has_bits(word, tables.word.rising)
    local item = add_sample(tree, f.word, range)
    for _, field in ipairs({f.tof, f.zero, f.rising, f.pixel}) do
        add_sample(item, field, range)
    end
    if fault then
        add_fault(item, fault)
        item:set_text(string.format("Bad word 0x%08x", word))
        return
    end
    local meters = range_of(tof, eye_name)
    item:add(f.return_number, range, number):set_generated()
    item:add(f.range, range, meters):set_generated()
    item:set_text(string.format("Pixel %d, %s %d: %.4f m (time of flight %d)", pixel_of(word),
                                rising and "rising" or "falling", number, meters, tof))
end

local function show_angles(tree, tvb, group, limit)
    for i = 0, math.min(group.num_samples, limit) - 1 do
        show_angle(tree, tvb, layout.samples + tables.sample_bytes * i, group, i)
    end
    return 0
end

-- All words are looked at, the first `limit` and those that are bad are shown.
local function show_words(tree, tvb, group, limit)
    local bad = 0
    local returns = {}
    for i = 0, group.num_samples - 1 do
        local range = tvb(layout.samples + tables.sample_bytes * i, tables.sample_bytes)
        local word = layout.sample_order == "little" and range:le_uint() or range:uint()
        local fault = word_fault(word)
        bad = bad + (fault and 1 or 0)
        if i < limit or fault then
            show_word(tree, range, word, group.eye_name, fault, not fault and count_return(returns, word))
        end
    end
    return bad
end

-- Whether a tree is on the screen, or a filter or column asks for a sample.
local function is_looked_at(tree)
    if tree.visible then
        return true
    end
    for _, field in ipairs(sample_fields) do
        if tree:referenced(field) then
            return true
        end
    end
    return false
end

local function show_samples(tree, tvb, group)
    local limit = is_looked_at(tree) and lum.prefs.samples or 0
    local bytes = tables.sample_bytes * group.num_samples
    local samples = tree:add(f.samples, tvb(layout.samples, bytes))
    local is_angles = group.tag == tables.tags.angles
    samples:set_text("Samples: " .. group.num_samples)
    if limit < group.num_samples then
        samples:append_text(string.format(", the first %d are shown", limit))
    end
    local bad = (is_angles and show_angles or show_words)(samples, tvb, group, limit)
    local bad_item = tree:add(f.bad_words, tvb(layout.samples, bytes), bad)
    bad_item:set_generated()
    if bad > 0 then
        add_fault(bad_item, "bad_words")
    end
    show_rest(tree, tvb, layout.samples + bytes)
    return bad
end

local group_order = {"tag", "eye", "line", "num_samples", "first_sample_index", "timestamp"}

local function show_group_field(tree, name, range, value)
    if name == "timestamp" then
        return tree:add(f[name], range, value):append_text(string.format(" of %d ns", layout.unit_ns))
    end
    local number = value:lower()
    if name ~= "eye" then
        return tree:add(f[name], range, number)
    end
    local item = tree:add(f.eye, range, eye_names[value:tonumber()] or "unknown")
    item:add(f.eye_value, range, number)
    return item
end

-- The fields of a data packet as far as it reaches.
local function show_group(tree, tvb)
    local items = {}
    for _, name in ipairs(group_order) do
        local field = layout.group[name]
        if field.bytes > 0 and field.at + field.bytes <= tvb:len() then
            items[name] = show_group_field(tree, name, tvb(field.at, field.bytes), load_field(tvb, field))
        end
    end
    return items
end

local fault_fields = {no_samples = "num_samples", samples_short = "num_samples", eye = "eye", tag = "tag",
                      angles_past_end = "first_sample_index"}

local function rejected_info(kind, fault)
    local label = kind:gsub("_", " "):gsub("^%l", string.upper)
    return label .. ": " .. faults[fault].text
end

local function show_data(tree, tvb, way, kind, fault, group)
    local items = show_group(tree, tvb)
    if group and not items.num_samples then
        items.num_samples = tree:add(f.num_samples, group.num_samples)
        items.num_samples:set_generated()
    end
    if fault then
        add_fault(items[fault_fields[fault]] or tree, fault)
        return rejected_info(kind, fault)
    end
    if not way.visited then
        note_missing(way, group)
    end
    local lost = missing[way.key]
    if lost then
        local item = tree:add(f.missing, lost)
        item:set_generated()
        add_fault(item, "missing", tostring(lost))
    end
    local bad = show_samples(tree, tvb, group)
    return string.format("Data %s line %d %s %d samples from %d clock %s%s", group.eye_name, group.line,
                         group.tag_name, group.num_samples, group.first_sample_index, tostring(group.timestamp),
                         bad > 0 and string.format(" [%d bad]", bad) or "")
end

-- A datagram -----------------------------------------------------------------

local show = {
    set_ip = show_set_ip,
    timestamp = show_timestamp,
    tlv = show_tlvs,
    heartbeat = function() return "Heartbeat" end,
}

local function show_rejected(tree, tvb, kind, fault)
    if fault ~= "reserved" then
        add_fault(tree, fault)
    end
    if fault == "type" then
        return string.format("Unknown type %d, %d bytes", tvb(TYPE_AT, 1):uint(), tvb:len())
    end
    return rejected_info(kind, fault)
end

local function show_packet(tree, tvb, way, kind, fault, group)
    show_header(tree, tvb, fault)
    if show[kind] then
        return show[kind](tree, tvb, way)
    elseif group or fault == "data_short" then
        return show_data(tree, tvb, way, kind, fault, group)
    end
    return show_rejected(tree, tvb, kind, fault)
end

local function add_kind(root, range, kind)
    local tree = range and root:add(lum, range) or root:add(lum)
    tree:append_text(", " .. kind)
    tree:add(f.kind, kind):set_generated()
    if layout_fault then
        add_fault(tree, "layout", layout_fault)
    end
    return tree
end

-- A datagram; how many of its bytes are ours.
local function dissect_one(tvb, way, root)
    local kind, fault, group = classify(tvb)
    local tree = add_kind(root, tvb(), kind)
    if kind == tables.kinds.foreign then
        add_fault(tree, fault)
        return 0 -- others may know it
    end
    way.cols.protocol = "LUM"
    way.cols.info = show_packet(tree, tvb, way, kind, fault, group)
    return tvb:len()
end

local magic_bytes = tables.magic:gsub("%x%x", function(digits) return string.char(tonumber(digits, 16)) end)

-- Bytes of each of several datagrams that a receiving host has joined, or of
-- all where it is one (docs/protocol.md, 9).
local function bytes_of_each(tvb)
    local bytes = tvb:raw()
    local function has_magic(at)
        return bytes:sub(at + 1, at + #magic_bytes) == magic_bytes
    end
    local each = has_magic(0) and (bytes:find(magic_bytes, 2, true) or 1) - 1 or 0
    if each < HEADER then
        return #bytes
    end
    for at = each, #bytes - 1, each do
        if not has_magic(at) then
            return #bytes
        end
    end
    return each
end

-- A payload: one datagram, or several joined ones.
local function dissect(tvb, way, root)
    local each, length = bytes_of_each(tvb), tvb:len()
    if each == length then
        return dissect_one(tvb, way, root)
    end
    local count = math.ceil(length / each)
    root:add(f.joined, count):set_generated()
    for part = 1, count do
        local at = (part - 1) * each
        way.key = way.number .. "/" .. part
        dissect_one(tvb(at, math.min(each, length - at)):tvb(), way, root)
    end
    way.cols.info:prepend(string.format("%d joined, the last: ", count))
    return length
end

-- A datagram that is not decoded: of one cut short, the fields that came.
local function dissect_outside(tvb, pinfo, root, kind, fault)
    local tree = add_kind(root, tvb(), kind)
    add_fault(tree, fault)
    if kind ~= "cut_short" or header_fault(tvb) then
        return 0
    end
    show_header(tree, tvb)
    if is_data_type(tvb(TYPE_AT, 1):uint()) then
        show_group(tree, tvb)
    end
    pinfo.cols.protocol = "LUM"
    pinfo.cols.info = string.format("Cut short: %d of %d bytes", tvb:len(), tvb:reported_len())
    return tvb:len()
end

-- An ICMP message quotes it: no packet of its own, so without a kind.
local function dissect_quoted(tvb, root)
    if header_fault(tvb) then
        return 0
    end
    local tree = root:add(lum, tvb())
    tree:append_text(", quoted")
    show_header(tree, tvb)
    return tvb:len()
end

local taken = {} -- frames whose fragments are put together here, not by Wireshark
local told       -- the last frame that got its kind here

function lum.dissector(tvb, pinfo, root)
    if pinfo.in_error_pkt then
        return dissect_quoted(tvb, root)
    elseif is_fragment() and not (pinfo.visited and not taken[pinfo.number]) then
        return 0 -- see below
    end
    told = pinfo.number
    local kind, fault
    if not is_fragment() then
        kind, fault = transport_fault(tvb, pinfo)
    end
    if kind then
        return dissect_outside(tvb, pinfo, root, kind, fault)
    end
    return dissect(tvb, way_of(pinfo, pinfo.src_port, pinfo.dst_port), root)
end

-- Fragments ------------------------------------------------------------------
-- Wireshark's own reassembly has no time limit and takes overlaps, so it can
-- join what does not belong together. The rules here are lumdump's. They need
-- a tree when a frame is first read; without one Wireshark's have to do.

local WAIT_S = 0.5
local WAITING_MAX = 64
local DATAGRAM_MAX = 65535

local waiting = {}   -- datagrams in the order in which they began
local whole = {}     -- those that were joined, the latest last, to know repeats
local completed = {} -- of a frame: the datagram's bytes, count of fragments

local function find_waiting(key)
    for place, datagram in ipairs(waiting) do
        if datagram.key == key then
            return datagram, place
        end
    end
    return nil
end

local function make_room()
    if #waiting == WAITING_MAX then
        table.remove(waiting, 1)
    elseif #waiting + #whole == WAITING_MAX then
        table.remove(whole, 1)
    end
end

local function expire(now)
    for place = #waiting, 1, -1 do
        if now - waiting[place].since > WAIT_S then
            table.remove(waiting, place)
        end
    end
end

-- Whether all of a fragment is there already, and the same.
local function repeats(datagram, fragment)
    local own_end, same = fragment.offset + fragment.length, 0
    for _, other in ipairs(datagram) do
        local from = math.max(fragment.offset, other.offset)
        local held = math.min(own_end, other.offset + other.length) - from
        if held > 0 then
            if fragment.bytes:subset(from - fragment.offset, held) ~= other.bytes:subset(from - other.offset, held) then
                return false
            end
            same = same + held
        end
    end
    local total = datagram.total
    local fits = fragment.more and (not total or own_end < total) or not fragment.more and own_end == total
    return fits and same == fragment.length
end

local function repeats_whole(key, now, fragment)
    for _, datagram in ipairs(whole) do
        if datagram.key == key and now - datagram.since <= WAIT_S and repeats(datagram, fragment) then
            return true
        end
    end
    return false
end

-- Whether a fragment fits to those that wait.
local function fits(datagram, fragment)
    for _, other in ipairs(datagram) do
        local other_end = math.ceil((other.offset + other.length) / 8) * 8
        local own_end = math.ceil((fragment.offset + fragment.length) / 8) * 8
        if fragment.offset < other_end and other.offset < own_end then
            return false
        end
    end
    local reach = math.max(datagram.reach, fragment.offset + fragment.length)
    if not fragment.more and datagram.total then
        return false
    end
    local total = datagram.total or (not fragment.more and fragment.offset + fragment.length)
    return not total or reach <= total
end

local function join(datagram)
    table.sort(datagram, function(a, b) return a.offset < b.offset end)
    local bytes = ByteArray.new()
    for _, fragment in ipairs(datagram) do
        bytes = bytes .. fragment.bytes
    end
    return {bytes = bytes, count = #datagram}
end

-- Keeps a fragment; the datagram when it is the last that was missing.
local function keep(key, now, fragment)
    local datagram, place = find_waiting(key)
    if datagram and repeats(datagram, fragment) or not datagram and repeats_whole(key, now, fragment) then
        return nil
    elseif not datagram then
        make_room()
        datagram, place = {key = key, since = now, held = 0, reach = 0}, #waiting + 1
        waiting[place] = datagram
    end
    if not fits(datagram, fragment) then
        table.remove(waiting, place)
        return nil
    end
    datagram[#datagram + 1] = fragment
    datagram.held = datagram.held + fragment.length
    datagram.reach = math.max(datagram.reach, fragment.offset + fragment.length)
    datagram.total = datagram.total or (not fragment.more and datagram.reach) or nil
    if datagram.held == datagram.total then
        whole[#whole + 1] = table.remove(waiting, place)
        return join(datagram)
    end
    return nil
end

-- The frame's IPv4 packet, taken apart again.
local function read_ip(tvb)
    local at = ip_version().offset
    local header, total = last(ip_header()), last(ip_length())
    local flags = tvb(at + 6, 2):uint()
    return {
        key = tvb(at + 12, 8):bytes():tohex() .. tvb(at + 4, 2):bytes():tohex(),
        data = at + header,
        whole = total - header,
        held = math.min(tvb:len() - at, total) - header,
        offset = flags % 0x2000 * 8,
        more = has_bits(flags, 0x2000),
        header = header,
    }
end

local function is_fragment_fit(ip)
    return ip.whole > 0 and not (ip.more and ip.whole % 8 ~= 0)
        and ip.header + ip.offset + ip.whole <= DATAGRAM_MAX
end

-- Ports and payload of the UDP datagram at the start of tvb; nil unless ours.
local function read_udp(tvb)
    if tvb:len() < 6 then
        return nil
    end
    local udp = {src = tvb(0, 2):uint(), dst = tvb(2, 2):uint(), length = tvb(4, 2):uint()}
    return (is_our_port(udp.src) or is_our_port(udp.dst)) and udp or nil
end

local function dissect_reassembled(done, pinfo, root)
    local tvb = done.bytes:tvb("G2 datagram")
    local udp = read_udp(tvb)
    if not udp then
        return
    end
    root:add(f.fragments, done.count):set_generated()
    if udp.length < UDP_BYTES or udp.length > tvb:len() then
        add_fault(add_kind(root, nil, "other"), "length")
    elseif udp.length == UDP_BYTES then
        add_fault(add_kind(root, nil, tables.kinds.foreign), "short")
    else
        dissect(tvb(UDP_BYTES, udp.length - UDP_BYTES):tvb(), way_of(pinfo, udp.src, udp.dst), root)
    end
end

local function take_fragment(tvb, pinfo, ip)
    taken[pinfo.number] = taken[pinfo.number] or not pinfo.visited
    if not pinfo.visited and is_fragment_fit(ip) and ip.held == ip.whole then
        completed[pinfo.number] = keep(ip.key, pinfo.rel_ts, {
            offset = ip.offset, length = ip.whole, more = ip.more, bytes = tvb(ip.data, ip.whole):bytes()})
    end
    return completed[pinfo.number]
end

-- What never reaches a dissector: a datagram cut within its UDP header or cut
-- in fragments, and an empty one. Without its ports a cut one may be ours.
local function bare_kind(tvb, ip)
    local function port_at(at)
        return ip.held >= at + 2 and tvb(ip.data + at, 2):uint() or nil
    end
    local src, dst, length = port_at(0), port_at(2), port_at(4)
    if src and dst and not is_our_port(src) and not is_our_port(dst) then
        return nil
    elseif length and (length < UDP_BYTES or length > (ip.offset == 0 and ip.more and DATAGRAM_MAX or ip.whole)) then
        return nil
    elseif ip.held < ip.whole then
        return "cut_short", "cut_short"
    elseif length == UDP_BYTES then
        return tables.kinds.foreign, "short"
    end
    return nil
end

local rest = Proto("lum_rest", "Luminar Model G2, fragments and bare datagrams")

local function dissect_rest(tvb, pinfo, root)
    local ip = read_ip(tvb)
    local fragmented = ip.more or ip.offset > 0
    local done = fragmented and take_fragment(tvb, pinfo, ip)
    if done then
        dissect_reassembled(done, pinfo, root)
    elseif ip.offset == 0 and told ~= pinfo.number and (ip.held < ip.whole or not fragmented) then
        local kind, fault = bare_kind(tvb, ip)
        if kind then
            add_fault(add_kind(root, nil, kind), fault)
        end
    end
end

function rest.dissector(tvb, pinfo, root)
    if not pinfo.visited and #waiting > 0 then
        expire(pinfo.rel_ts)
    end
    if select("#", ip_protocol()) == 1 and last(ip_protocol()) == UDP then
        dissect_rest(tvb, pinfo, root)
    end
end
register_postdissector(rest)

function lum.init()
    requests, links, streams, missing = {}, {}, {}, {}
    waiting, completed, taken = {}, {}, {}
end

-- Ports ----------------------------------------------------------------------

local udp_table = DissectorTable.get("udp.port")
local ports = lum.prefs.ports
udp_table:add(ports, lum)

function lum.prefs_changed()
    take_layout()
    if lum.prefs.ports ~= ports then
        udp_table:remove(ports, lum)
        ports = lum.prefs.ports
        udp_table:add(ports, lum)
    end
end
