-- Preferences: the ports of sensors, how much is shown, and the layout by which packets are read.

local lum = fields.proto

lum.prefs.ports = Pref.range("UDP ports", tostring(tables.port), "Ports of sensors", 65535)
lum.prefs.samples = Pref.uint("Samples in the tree", 400,
                              "Samples of a data packet that are shown at most; 0 shows none")
lum.prefs.layout = Pref.string("Layout", "",
                               "Keys of a wire profile that differ from the default, such as: "
                               .. "tag=13 eye=12/1 line=16/2/big/0-14 samples=28 blue=66 green=71 "
                               .. "angle_order=elevation_azimuth")

-- The layout ------------------------------------------------------------------

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

local maxima = {data_packet_type = 255, unit_ns = 1000000000, samples = 64}
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
    elseif maxima[key] then
        return set_number(l, key, text, maxima[key]) and l.unit_ns > 0
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

-- layout: what decoders go by; fault: the word of the preference that was not understood.
local settings = {}

-- Names by their numbers.
local function names_of(numbers)
    local names = {}
    for name, number in pairs(numbers) do
        names[number] = name
    end
    return names
end

function settings.read()
    local layout, fault = read_layout(lum.prefs.layout or "")
    layout.eye_names, layout.tlv_names = names_of(layout.eye_values), names_of(layout.tlv)
    settings.layout, settings.fault = layout, fault
end
settings.read()

-- Ports -----------------------------------------------------------------------

local port_text, port_ranges = nil, {}

function settings.is_our_port(port)
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

return settings
