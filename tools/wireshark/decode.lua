-- What the bytes of a datagram are: its kind, its fault, fields and values; lum_packet_decode() in Lua.
-- Only arithmetic that Lua 5.1 to 5.4 share is used: Wireshark has had several of them.

local TYPE_AT = tables.type_at
local HEADER = tables.header_bytes
local tag_names = fields.tag_names

-- Values ----------------------------------------------------------------------

local function has_bits(value, mask)
    return math.floor(value / mask) % 2 == 1
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
    local center, lsb_pdeg = (min + max) / 2, settings.layout.angle_lsb_pdeg
    if lsb_pdeg > 0 then
        return center / 1e6 + raw * lsb_pdeg * 1e-12
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

-- Kinds -----------------------------------------------------------------------

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

local function is_data_type(number)
    if settings.layout.group.tag.at < HEADER then
        return tag_names[number] ~= nil
    end
    return number == settings.layout.data_packet_type
end

local function read_group(tvb)
    local group = {}
    for name, field in pairs(settings.layout.group) do
        local value = load_field(tvb, field)
        group[name] = name == "timestamp" and value or value:tonumber()
    end
    if settings.layout.group.num_samples.bytes == 0 then
        group.num_samples = math.floor((tvb:len() - settings.layout.samples) / tables.sample_bytes)
    end
    group.eye_name = settings.layout.eye_names[group.eye]
    group.tag_name = tag_names[group.tag]
    return group
end

-- The kind of a data packet, the fault, what was read of it.
local function classify_data(tvb)
    local room = tvb:len() - settings.layout.samples
    if room < 0 then
        return "malformed", "data_short"
    end
    local group = read_group(tvb)
    if group.num_samples == 0 then
        return "malformed", "no_samples", group
    elseif math.max(group.line, group.num_samples, group.first_sample_index) > 0xffffffff and group.eye <= 0xffffffff then
        return "malformed", "wide", group
    elseif group.num_samples * tables.sample_bytes > room then
        return "malformed", "samples_short", group
    elseif not group.eye_name then
        return "malformed", "eye", group
    elseif not group.tag_name then
        return "unknown_tag", "tag", group
    elseif group.tag == tables.tags.angles and group.first_sample_index + group.num_samples > tables.line_pixels then
        return "malformed", "angles_past_end", group
    end
    return "data", nil, group
end

local names_by_type = {
    [tables.types.set_ip] = "set_ip", [tables.types.timestamp] = "timestamp", [tables.types.tlv] = "tlv"}

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
        return kind, fault
    end
    local number = tvb(TYPE_AT, 1):uint()
    local name = names_by_type[number]
    if number == tables.types.heartbeat and tvb:len() == tables.bytes.heartbeat then
        return "heartbeat"
    elseif is_data_type(number) then
        return classify_data(tvb)
    elseif not name then
        return "unknown_type", "type"
    elseif tvb:len() < tables.bytes[name] then
        return "malformed", name .. "_short"
    end
    return name
end

return {has_bits = has_bits, tof_of = tof_of, pixel_of = pixel_of, azimuth_of = azimuth_of, elevation_of = elevation_of,
        range_of = range_of, parse_command = parse_command, load_field = load_field, is_data_type = is_data_type,
        header_fault = header_fault, classify = classify}
