-- From a payload to its trees: what Wireshark calls.
-- What the packets are: docs/protocol.md; how this is installed and used: docs/wireshark.md.

local TYPE_AT = tables.type_at
local HEADER = tables.header_bytes

local lum, f, add_fault = fields.proto, fields.f, fields.add_fault

-- What is told of a packet's way: its ends as text, ports, frame, time. The
-- key is the frame, or one of several datagrams in it.
local function way_of(pinfo, src_port, dst_port)
    return {src = tostring(pinfo.src), dst = tostring(pinfo.dst), src_port = src_port, dst_port = dst_port,
            number = pinfo.number, key = pinfo.number, visited = pinfo.visited, time = pinfo.rel_ts, cols = pinfo.cols}
end

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

local function show_rejected(tree, tvb, kind, fault)
    if fault ~= "reserved" then
        add_fault(tree, fault)
    end
    if fault == "type" then
        return string.format("Unknown type %d, %d bytes", tvb(TYPE_AT, 1):uint(), tvb:len())
    end
    return fields.rejected_info(kind, fault)
end

local function show_packet(tree, tvb, way, kind, fault, group)
    show_header(tree, tvb, fault)
    if control.show[kind] then
        return control.show[kind](tree, tvb, way)
    elseif group or fault == "data_short" then
        return data.show(tree, tvb, way, kind, fault, group)
    end
    return show_rejected(tree, tvb, kind, fault)
end

local function add_kind(root, range, kind)
    local tree = range and root:add(lum, range) or root:add(lum)
    tree:append_text(", " .. kind)
    tree:add(f.kind, kind):set_generated()
    if settings.fault then
        add_fault(tree, "layout", settings.fault)
    end
    return tree
end

-- A datagram; how many of its bytes are ours.
local function dissect_one(tvb, way, root)
    local kind, fault, group = decode.classify(tvb)
    local tree = add_kind(root, tvb(), kind)
    if kind == "foreign" then
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
    if kind ~= "cut_short" or decode.header_fault(tvb) then
        return 0
    end
    show_header(tree, tvb)
    if decode.is_data_type(tvb(TYPE_AT, 1):uint()) then
        data.show_group(tree, tvb)
    end
    pinfo.cols.protocol = "LUM"
    pinfo.cols.info = string.format("Cut short: %d of %d bytes", tvb:len(), tvb:reported_len())
    return tvb:len()
end

-- An ICMP message quotes it: no packet of its own, so without a kind.
local function dissect_quoted(tvb, root)
    if decode.header_fault(tvb) then
        return 0
    end
    local tree = root:add(lum, tvb())
    tree:append_text(", quoted")
    show_header(tree, tvb)
    return tvb:len()
end

local told -- the last frame that got its kind here

function lum.dissector(tvb, pinfo, root)
    if pinfo.in_error_pkt then
        return dissect_quoted(tvb, root)
    end
    told = pinfo.number
    local kind, fault = transport.fault(tvb, pinfo)
    if kind then
        return dissect_outside(tvb, pinfo, root, kind, fault)
    end
    return dissect(tvb, way_of(pinfo, pinfo.src_port, pinfo.dst_port), root)
end

-- Datagrams that Wireshark shows to no dissector ------------------------------

local rest = Proto("lum_rest", "Luminar Model G2, bare datagrams")

function rest.dissector(tvb, pinfo, root)
    if told == pinfo.number or not transport.is_udp() then
        return
    end
    local ip = transport.read_ip(tvb)
    if ip.offset == 0 and (ip.held < ip.whole or not ip.more) then
        local kind, fault = transport.bare_kind(tvb, ip)
        if kind then
            add_fault(add_kind(root, nil, kind), fault)
        end
    end
end
register_postdissector(rest)

function lum.init()
    control.reset()
    data.reset()
    told = nil
end

-- Ports -----------------------------------------------------------------------

local udp_table = DissectorTable.get("udp.port")
local ports = lum.prefs.ports
udp_table:add(ports, lum)

function lum.prefs_changed()
    settings.read()
    if lum.prefs.ports ~= ports then
        udp_table:remove(ports, lum)
        ports = lum.prefs.ports
        udp_table:add(ports, lum)
    end
end
