-- How a datagram came (docs/protocol.md, 9): what the capture holds of it.

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
    if not last(frame_length()) then
        return nil
    elseif is_fragment() then
        -- Wireshark joins fragments, unless that is switched off
        if last(udp_length()) > tvb:len() + UDP_BYTES then
            return "cut_short", "cut_short"
        end
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
        data = at + header,
        whole = total - header,
        held = math.min(tvb:len() - at, total) - header,
        offset = flags % 0x2000 * 8,
        more = decode.has_bits(flags, 0x2000),
    }
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
    elseif length and (length < UDP_BYTES or length > (ip.offset == 0 and ip.more and 65535 or ip.whole)) then
        return nil
    elseif ip.held < ip.whole then
        return "cut_short", "cut_short"
    elseif length == UDP_BYTES then
        return "foreign", "short"
    end
    return nil
end

return {fault = transport_fault, is_udp = is_udp, read_ip = read_ip, bare_kind = bare_kind}
