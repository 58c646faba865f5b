-- How a datagram came (docs/protocol.md, 9): what the capture holds of it, and fragments, joined by lumdump's rules.

local UDP = 17
local UDP_BYTES = 8

local frame_length = Field.new("frame.len")
local ip_version = Field.new("ip.version")
local ip_length = Field.new("ip.len")
local ip_header = Field.new("ip.hdr_len")
local ip_protocol = Field.new("ip.proto")
local ip_more = Field.new("ip.flags.mf")
local ip_offset = Field.new("ip.frag_offset")
local udp_length = Field.new("udp.length")

local function last(...)
    local n = select("#", ...)
    return n > 0 and (select(n, ...)).value or nil
end

local function is_fragment()
    local more, offset = last(ip_more()), last(ip_offset())
    return more == true or more == 1 or (offset or 0) > 0
end

-- Why a datagram is not decoded at all, if so. Fields exist only where Wireshark
-- builds a tree; where it does not, it wants no more than the columns.
local function transport_fault(tvb, pinfo)
    if is_fragment() or not last(frame_length()) then
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

-- Fragments -------------------------------------------------------------------
-- Wireshark's own reassembly has no time limit and takes overlaps, so it can
-- join what does not belong together. The rules here are lumdump's. They need
-- a tree when a frame is first read; without one Wireshark's have to do.

local WAIT_S = 0.5
local WAITING_MAX = 64
local DATAGRAM_MAX = 65535

local waiting = {}   -- datagrams in the order in which they began
local whole = {}     -- those that were joined, the latest last, to know repeats
local completed = {} -- of a frame: the datagram's bytes, count of fragments
local taken = {}     -- frames whose fragments are joined here, not by Wireshark

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

local function expire(pinfo)
    for place = pinfo.visited and 0 or #waiting, 1, -1 do
        if pinfo.rel_ts - waiting[place].since > WAIT_S then
            table.remove(waiting, place)
        end
    end
end

-- Whether all of a fragment is there already, and the same.
local function repeats(datagram, fragment)
    local same = 0
    for _, other in ipairs(datagram) do
        local from = math.max(fragment.offset, other.offset)
        local held = math.min(fragment.reach, other.reach) - from
        if held > 0 then
            if fragment.bytes:subset(from - fragment.offset, held) ~= other.bytes:subset(from - other.offset, held) then
                return false
            end
            same = same + held
        end
    end
    local total = datagram.total
    local may_go_on = fragment.more and (not total or fragment.reach < total)
    return (may_go_on or not fragment.more and fragment.reach == total) and same == fragment.length
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
        if fragment.offset < math.ceil(other.reach / 8) * 8 and other.offset < math.ceil(fragment.reach / 8) * 8 then
            return false
        end
    end
    if not fragment.more then
        return not datagram.total and datagram.reach <= fragment.reach
    end
    return not datagram.total or fragment.reach <= datagram.total
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
    datagram.reach = math.max(datagram.reach, fragment.reach)
    datagram.total = datagram.total or (not fragment.more and datagram.reach) or nil
    if datagram.held == datagram.total then
        whole[#whole + 1] = table.remove(waiting, place)
        return join(datagram)
    end
    return nil
end

-- Whether a frame holds UDP alone, and not an ICMP message that quotes it.
local function is_udp()
    return select("#", ip_protocol()) == 1 and last(ip_protocol()) == UDP
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
        more = decode.has_bits(flags, 0x2000),
        header = header,
    }
end

-- Ports and payload of the UDP datagram at the start of tvb; nil unless ours.
local function read_udp(tvb)
    if tvb:len() < 6 then
        return nil
    end
    local udp = {src = tvb(0, 2):uint(), dst = tvb(2, 2):uint(), length = tvb(4, 2):uint()}
    return (settings.is_our_port(udp.src) or settings.is_our_port(udp.dst)) and udp or nil
end

-- Whether a frame's fragment is joined here, so that Wireshark's own datagram of it is not shown.
local function is_joined_here(pinfo)
    return is_fragment() and (not pinfo.visited or taken[pinfo.number])
end

-- The datagram that ends with this fragment, if any.
local function take_fragment(tvb, pinfo, ip)
    taken[pinfo.number] = taken[pinfo.number] or not pinfo.visited
    local is_valid = ip.whole > 0 and not (ip.more and ip.whole % 8 ~= 0)
        and ip.header + ip.offset + ip.whole <= DATAGRAM_MAX
    if not pinfo.visited and is_valid and ip.held == ip.whole then
        completed[pinfo.number] = keep(ip.key, pinfo.rel_ts, {
            offset = ip.offset, length = ip.whole, reach = ip.offset + ip.whole, more = ip.more,
            bytes = tvb(ip.data, ip.whole):bytes()})
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
    if src and dst and not settings.is_our_port(src) and not settings.is_our_port(dst) then
        return nil
    elseif length and (length < UDP_BYTES or length > (ip.offset == 0 and ip.more and DATAGRAM_MAX or ip.whole)) then
        return nil
    elseif ip.held < ip.whole then
        return "cut_short", "cut_short"
    elseif length == UDP_BYTES then
        return "foreign", "short"
    end
    return nil
end

return {UDP_BYTES = UDP_BYTES, fault = transport_fault, is_udp = is_udp, read_ip = read_ip, read_udp = read_udp,
        is_joined_here = is_joined_here, take_fragment = take_fragment, bare_kind = bare_kind, expire = expire,
        reset = function() waiting, whole, completed, taken = {}, {}, {}, {} end}
