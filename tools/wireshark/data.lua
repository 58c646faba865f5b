-- Trees of data packets: their fields, their samples, and the samples that did not come.

local f, add_fault = fields.f, fields.add_fault
local has_bits, pixel_of = decode.has_bits, decode.pixel_of

-- Samples that did not come ---------------------------------------------------

local streams = {} -- of an eye and a tag: line and next index
local missing = {} -- of a frame: samples that should have come before it

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

-- Samples ---------------------------------------------------------------------

-- Samples are in the order of bytes that the layout says.
local function int_of(range)
    return settings.layout.sample_order == "little" and range:le_int() or range:int()
end

local function add_sample(tree, field, range)
    return settings.layout.sample_order == "little" and tree:add_le(field, range) or tree:add(field, range)
end

local function show_angle(tree, tvb, at, group, i)
    local azimuth_range, elevation_range = tvb(at, 2), tvb(at + 2, 2)
    if settings.layout.angle_order ~= "azimuth_elevation" then
        azimuth_range, elevation_range = elevation_range, azimuth_range
    end
    local azimuth_raw, elevation_raw = int_of(azimuth_range), int_of(elevation_range)
    local azimuth = decode.azimuth_of(azimuth_raw, group.eye_name)
    local elevation = decode.elevation_of(elevation_raw, group.eye_name)
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
    local tof, rising = decode.tof_of(word), has_bits(word, tables.word.rising)
    local item = add_sample(tree, f.word, range)
    for _, field in ipairs({f.tof, f.zero, f.rising, f.pixel}) do
        add_sample(item, field, range)
    end
    if fault then
        add_fault(item, fault)
        item:set_text(string.format("Bad word 0x%08x", word))
        return
    end
    local meters = decode.range_of(tof, eye_name)
    item:add(f.return_number, range, number):set_generated()
    item:add(f.range, range, meters):set_generated()
    item:set_text(string.format("Pixel %d, %s %d: %.4f m (time of flight %d)", pixel_of(word),
                                rising and "rising" or "falling", number, meters, tof))
end

local function show_angles(tree, tvb, group, limit)
    for i = 0, math.min(group.num_samples, limit) - 1 do
        show_angle(tree, tvb, settings.layout.samples + tables.sample_bytes * i, group, i)
    end
    return 0
end

-- All words are looked at, the first `limit` and those that are bad are shown.
local function show_words(tree, tvb, group, limit)
    local bad = 0
    local returns = {}
    for i = 0, group.num_samples - 1 do
        local range = tvb(settings.layout.samples + tables.sample_bytes * i, tables.sample_bytes)
        local word = settings.layout.sample_order == "little" and range:le_uint() or range:uint()
        local fault = word_fault(word)
        bad = bad + (fault and 1 or 0)
        if i < limit or fault then
            show_word(tree, range, word, group.eye_name, fault, not fault and count_return(returns, word))
        end
    end
    return bad
end

local sample_fields = {f.angle, f.angle_pixel, f.azimuth_raw, f.azimuth, f.elevation_raw, f.elevation, f.word, f.tof,
                       f.zero, f.rising, f.pixel, f.return_number, f.range}

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
    local limit = is_looked_at(tree) and fields.proto.prefs.samples or 0
    local bytes = tables.sample_bytes * group.num_samples
    local samples = tree:add(f.samples, tvb(settings.layout.samples, bytes))
    local is_angles = group.tag == tables.tags.angles
    samples:set_text("Samples: " .. group.num_samples)
    if limit < group.num_samples then
        samples:append_text(string.format(", the first %d are shown", limit))
    end
    local bad = (is_angles and show_angles or show_words)(samples, tvb, group, limit)
    local bad_item = tree:add(f.bad_words, tvb(settings.layout.samples, bytes), bad)
    bad_item:set_generated()
    if bad > 0 then
        add_fault(bad_item, "bad_words")
    end
    fields.add_rest(tree, tvb, settings.layout.samples + bytes)
    return bad
end

-- Fields ----------------------------------------------------------------------

local group_order = {"tag", "eye", "line", "num_samples", "first_sample_index", "timestamp"}

local function show_group_field(tree, name, range, value)
    if name == "timestamp" then
        return tree:add(f[name], range, value):append_text(string.format(" of %d ns", settings.layout.unit_ns))
    end
    local number = value:lower()
    if name ~= "eye" then
        return tree:add(f[name], range, number)
    end
    local item = tree:add(f.eye, range, settings.layout.eye_names[value:tonumber()] or "unknown")
    item:add(f.eye_value, range, number)
    return item
end

-- The fields of a data packet as far as it reaches.
local function show_group(tree, tvb)
    local items = {}
    for _, name in ipairs(group_order) do
        local field = settings.layout.group[name]
        if field.bytes > 0 and field.at + field.bytes <= tvb:len() then
            items[name] = show_group_field(tree, name, tvb(field.at, field.bytes), decode.load_field(tvb, field))
        end
    end
    return items
end

local fault_fields = {no_samples = "num_samples", samples_short = "num_samples", eye = "eye", tag = "tag",
                      angles_past_end = "first_sample_index"}

local function show_data(tree, tvb, way, kind, fault, group)
    local items = show_group(tree, tvb)
    if group and not items.num_samples then
        items.num_samples = tree:add(f.num_samples, group.num_samples)
        items.num_samples:set_generated()
    end
    if fault then
        add_fault(items[fault_fields[fault]] or tree, fault)
        return fields.rejected_info(kind, fault)
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

return {show = show_data, show_group = show_group, reset = function() streams, missing = {}, {} end}
