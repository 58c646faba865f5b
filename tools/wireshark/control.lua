-- Trees of set IP, timestamp and TLV packets, and which answer belongs to which request.

local BODY = tables.header_bytes -- what follows the header

local f, add_fault = fields.f, fields.add_fault

-- Requests and answers --------------------------------------------------------

local requests = {} -- of a sequence number, not answered yet: frame, time
local links = {}    -- of a frame: request, answer, time

local function to_sensor(way)
    return settings.is_our_port(way.dst_port) and not settings.is_our_port(way.src_port)
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
        local note = asks and ask or reply
        note(way, key)
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

-- Set IP and timestamps -------------------------------------------------------

local function show_set_ip(tree, tvb)
    local range = tvb(BODY, 4)
    local network, little = range:ipv4(), range:le_ipv4()
    local is_network = settings.layout.set_ip_order == "network"
    local address = is_network and network or little
    local item = tree:add(f.set_ip, range, address)
    tree:add(f.set_ip_other, range, is_network and little or network):set_generated()
    local first = is_network and range(0, 1):uint() or range(3, 1):uint()
    local value = range:uint()
    if value == 0 or value == 0xffffffff or math.floor(first / 16) == 0xe then
        add_fault(item, "address")
    end
    fields.add_rest(tree, tvb, tables.bytes.set_ip)
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
    fields.add_rest(tree, tvb, tables.bytes.timestamp)
    if asks then
        return string.format("Timestamp request seq %d", sequence)
    end
    return string.format("Timestamp clock %d seq %d", clock, sequence)
end

-- TLVs ------------------------------------------------------------------------

-- Bytes as text, with what cannot be shown as \xNN.
local function printable(bytes)
    return (bytes:gsub("[^\32-\126]", function(c)
        return string.format("\\x%02x", c:byte())
    end))
end

local function text_of(tvb, at, length)
    return length > 0 and tvb:raw(at, length) or ""
end

local function show_command(tree, tvb, at, length)
    local text = text_of(tvb, at, length)
    local shown = printable(text)
    local item = tree:add(f.command_text, tvb(at, length), shown)
    if text == "" then
        add_fault(item, "command", "empty")
    end
    while text ~= "" do
        local row, value, written = decode.parse_command(text)
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

-- The names of the bits that are set in both; nil without any.
local function bit_names(status, mask)
    local names = {}
    for _, bit in ipairs(tables.laser.bits) do
        if decode.has_bits(status, bit.mask) and decode.has_bits(mask, bit.mask) then
            names[#names + 1] = bit.name
        end
    end
    return names[1] and table.concat(names, " ")
end

local function show_status(tree, tvb, at, length)
    if length < 2 then
        add_fault(tree, "status_short")
        return "status"
    end
    local range = tvb(at, 2)
    local status = range:le_uint()
    local names = bit_names(status, 0xffff) or "no bit"
    local down = bit_names(status, tables.laser.all_down) ~= nil
    local hazards = bit_names(status, tables.laser.hazards)
    local item = tree:add_le(f.status, range)
    item:append_text(" (" .. names .. ")")
    for _, bit in ipairs(tables.laser.bits) do
        item:add_le(f[bit.name], range)
    end
    tree:add(f.laser_down, range, down):set_generated()
    local hazard_item = tree:add(f.laser_hazard, range, hazards ~= nil)
    hazard_item:set_generated()
    if hazards then
        add_fault(hazard_item, "hazard", hazards)
    end
    if length > 2 then
        add_fault(item, "status_long")
    end
    local state = down and "down" or bit_names(status, tables.laser.on) and "up" or "may be up"
    return string.format("status 0x%04x laser %s: %s", status, state, names)
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
        local elevation = decode.elevation_of(range:le_int(), "blue")
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
    local name = settings.layout.tlv_names[number]
    item:append_text(": " .. (name or "type " .. number))
    item:add_le(f.tlv_type, tvb(at, 2)):append_text(" (" .. (name or "not known") .. ")")
    local length_item = item:add_le(f.tlv_length, tvb(at + 2, 2))
    if overrun then
        add_fault(length_item, "tlv_overrun", string.format("%d of %d", left - head, length))
        return nil, "[malformed]"
    end
    if not name then
        add_fault(item, "tlv_type")
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

local show = {set_ip = show_set_ip, timestamp = show_timestamp, tlv = show_tlvs,
              heartbeat = function() return "Heartbeat" end}

return {show = show, reset = function() requests, links = {}, {} end}
