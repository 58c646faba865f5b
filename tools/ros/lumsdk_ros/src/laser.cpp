#include "laser.hpp"

#include <algorithm>

namespace lumsdk_ros
{

namespace
{

constexpr int64_t second_ns = 1000000000;
constexpr int64_t poll_ns = second_ns / 2;

// A sensor that has just got its first heartbeat may still refuse the laser
// for want of one.
constexpr int64_t again_ns = second_ns / 5;
constexpr unsigned attempts_max = 20;
constexpr int64_t give_up_ns = 5 * second_ns;

// A node that was held up for so long sends no u: its heartbeats have ended,
// and nobody may expect it any more.
constexpr int64_t held_up_ns = 2 * second_ns;

constexpr size_t commands_max = 16;

std::string hex(uint16_t status)
{
    char text[8];
    (void)snprintf(text, sizeof text, "0x%04x", status);
    return text;
}

std::string printable(const uint8_t *bytes, size_t len)
{
    std::string text(bytes, bytes + std::min<size_t>(len, 200));
    for (char &c : text) {
        c = c >= ' ' && c <= '~' ? c : '?';
    }
    return text;
}

// Every command of a text. Returns what is wrong, or nothing.
std::string fault_of(const std::string &text, bool &switches_on,
                     bool &switches_off)
{
    const char *at = text.data();
    size_t left = text.size();
    lum_command command;
    lum_result r = LUM_OK;
    if (text.empty()) {
        return "no command; 50p u is an example";
    }
    while ((r = lum_command_parse(&at, &left, &command)) == LUM_OK) {
        switches_on |= command.id == LUM_COMMAND_LASER_ON;
        switches_off |= command.id == LUM_COMMAND_LASER_OFF;
    }
    const std::string where = " at character " +
                              std::to_string(text.size() - left + 1) +
                              "; 50p u is an example";
    if (r == LUM_E_VALUE) {
        return "a value that the manual does not allow" + where;
    }
    if (r != LUM_END) {
        return "no command of the manual's" + where;
    }
    return text.size() > 1000 ? "too long" : "";
}

// Hazards that heartbeats do not end.
bool has_lasting_hazard(uint16_t status)
{
    return (status & LUM_LASER_HAZARDS &
            ~unsigned{LUM_LASER_HEARTBEAT_TIMEOUT}) != 0;
}

} // namespace

/* --- Commands --- */

std::string bit_names(unsigned bits)
{
    std::string names;
    for (unsigned bit = 0; bit < LUM_LASER_BITS; bit++) {
        if ((bits >> bit & 1u) != 0) {
            names += (names.empty() ? "" : " ");
            names += lum_laser_bit_name(bit);
        }
    }
    return names.empty() ? "none" : names;
}

Laser::Laser(lum_sensor *sensor, const lum_layout &layout, bool wanted,
             Notes &notes)
    : sensor_(sensor), layout_(layout), notes_(notes),
      state_(wanted ? State::asked : State::untouched), is_ours_(wanted),
      began_ns_(lum_time_monotonic_ns()), tick_ns_(began_ns_)
{
}

void Laser::add(const std::string &text)
{
    bool on = false;
    bool off = false;
    const std::string fault = fault_of(text, on, off);
    if (!fault.empty()) {
        notes_.add(Note::answer,
                   printable(reinterpret_cast<const uint8_t *>(text.data()),
                             text.size()) +
                       ": refused, not sent: " + fault);
        return;
    }
    const std::lock_guard<std::mutex> guard(lock_);
    if (commands_.size() >= commands_max) {
        notes_.add(Note::answer,
                   text + ": refused, not sent: too many commands wait");
        return;
    }
    commands_.push_back(text);
}

bool Laser::next_command(std::string &text)
{
    const std::lock_guard<std::mutex> guard(lock_);
    if (commands_.empty()) {
        return false;
    }
    text = commands_.front();
    commands_.pop_front();
    return true;
}

bool Laser::send(Request request, const std::string &text)
{
    const lum_result r = request == Request::poll
                             ? lum_sensor_request(sensor_, nullptr, 0)
                             : lum_sensor_command(sensor_, text.c_str());
    request_ = r == LUM_OK ? request : Request::none;
    return r == LUM_OK;
}

/* --- Asking --- */

// Off comes before all else.
void Laser::ask(int64_t now_ns)
{
    refusal_.clear();
    if (is_off_due_) {
        (void)send(Request::off, "d");
    } else if (next_command(text_)) {
        bool off = false;
        bool on = false;
        (void)fault_of(text_, on, off);
        is_ours_ |= on;
        state_ = off ? State::untouched : state_;
        if (!send(Request::command, text_)) {
            notes_.add(Note::answer, text_ + ": refused, not sent: too long");
        }
    } else if (now_ns >= next_ns_) {
        const bool on = state_ == State::asked;
        next_ns_ = now_ns + poll_ns;
        attempts_ += on ? 1u : 0u;
        (void)send(on ? Request::on : Request::poll, "u");
    }
}

void Laser::tick(int64_t now_ns)
{
    if (state_ == State::asked && now_ns - tick_ns_ >= held_up_ns) {
        state_ = State::down;
        is_off_due_ = true;
        notes_.add(Note::error, "this node was held up while it switched the "
                                "laser on: it is switched off");
    }
    tick_ns_ = now_ns;
    if (is_off_due_ && request_ != Request::off) {
        give_up();
    }
    if (!lum_sensor_is_waiting(sensor_)) {
        ask(now_ns);
    }
}

// Off waits for nothing: what is under way would be sent again.
void Laser::give_up()
{
    if (request_ == Request::command) {
        notes_.add(Note::answer,
                   text_ + ": no answer, the laser is switched off");
    }
    lum_sensor_give_up(sensor_);
    request_ = Request::none;
}

/* --- Status --- */

void Laser::show_texts(lum_tlv_reader tlvs)
{
    const uint16_t debug = layout_.profile.tlv[LUM_TLV_DEBUG];
    lum_tlv tlv;
    while (lum_tlv_next(&tlvs, &tlv) == LUM_OK) {
        if (tlv.type == debug) {
            const std::string text = printable(tlv.value, tlv.length);
            refusal_ += (refusal_.empty() ? "" : "; ") + text;
            notes_.add(Note::warning, "the sensor says: " + text);
        }
    }
}

// The laser goes and comes.
void Laser::follow(uint16_t status)
{
    const bool is_down = lum_laser_is_down(status);
    if (state_ == State::up && is_down) {
        state_ = State::down;
        is_off_due_ =
            lum_laser_has_hazard(status) || (status & LUM_LASER_TLV_CMD_OFF) == 0;
        notes_.add(Note::error,
                   "the laser went off (" +
                       bit_names(status & LUM_LASER_ALL_DOWN) + ")" +
                       (is_off_due_ ? "; it is switched off, so that it does "
                                      "not come back by itself"
                                    : "") +
                       "; when that is safe, send u");
    } else if (is_ours_ && !is_down && state_ != State::up && !is_off_due_) {
        state_ = State::up;
        notes_.add(Note::info, "the laser is on");
    }
}

// A hazard counts at once where it is told of: it may be over before the
// answer. A u that it refuses must not stand either.
void Laser::take_hazard(uint16_t status)
{
    if (!is_ours_ || !has_lasting_hazard(status)) {
        return;
    }
    if (state_ == State::up) {
        follow(status);
    } else if (state_ != State::asked &&
               (status & LUM_LASER_TLV_CMD_OFF) == 0) {
        is_off_due_ = true;
    }
}

void Laser::note_status(uint16_t status, int64_t now_ns)
{
    const bool begins = now_ns - began_ns_ < second_ns;
    unsigned hazards = status & LUM_LASER_HAZARDS & ~unsigned{told_};
    if (begins) {
        hazards &= ~unsigned{LUM_LASER_HEARTBEAT_TIMEOUT};
    }
    has_status_ = true;
    status_ = status;
    told_ = static_cast<uint16_t>((told_ & status) | hazards);
    if (hazards != 0) {
        notes_.add(Note::warning,
                   "the sensor reports a hazard: " + bit_names(hazards));
    }
    follow(status);
    take_hazard(status);
}

/* --- Answers --- */

// The answer to u.
void Laser::judge_on(int64_t now_ns)
{
    const unsigned hazards =
        status_ & LUM_LASER_HAZARDS & ~unsigned{LUM_LASER_HEARTBEAT_TIMEOUT};
    if (!lum_laser_is_down(status_)) {
        return;
    }
    if (hazards == 0 && attempts_ < attempts_max) {
        next_ns_ = now_ns + again_ns;
        return;
    }
    state_ = State::down;
    is_off_due_ = true;
    notes_.add(Note::error, "the laser stays down (" +
                                bit_names(status_ & LUM_LASER_ALL_DOWN) +
                                "); it is switched off, so that it does not "
                                "come up by itself");
}

void Laser::judge_command(const lum_sensor_event &event)
{
    std::string outcome = ": answered";
    if (event.has_status) {
        outcome += ", status " + hex(event.status) + " (" +
                   bit_names(event.status) + "), laser " +
                   (lum_laser_is_down(event.status) ? "down" : "up");
    }
    if (!refusal_.empty()) {
        outcome += ", the sensor says: " + refusal_;
    }
    notes_.add(Note::answer, text_ + outcome);
}

void Laser::take_answer(const lum_sensor_event &event, int64_t now_ns)
{
    const Request request = request_;
    const bool is_asked = request == Request::on && state_ == State::asked;
    request_ = Request::none;
    is_unheard_ = false;
    show_texts(event.tlvs);
    if (request == Request::off) {
        is_off_due_ = event.has_status && !lum_laser_is_down(event.status);
    }
    if (event.has_status) {
        note_status(event.status, now_ns);
    }
    if (is_asked && event.has_status) {
        judge_on(now_ns);
    } else if (is_asked) {
        state_ = State::down;
        is_off_due_ = true;
        notes_.add(Note::error, "u was answered without a status: whether "
                                "the laser is on is not known, so it is "
                                "switched off (tlv.status of the profile)");
    } else if (request == Request::command) {
        judge_command(event);
        next_ns_ = now_ns;
    }
}

void Laser::take_no_answer(const lum_sensor_event &event, int64_t now_ns)
{
    const Request request = request_;
    request_ = Request::none;
    if (request == Request::on && state_ == State::asked &&
        now_ns - began_ns_ >= give_up_ns) {
        state_ = State::down;
        is_off_due_ = true;
        notes_.add(Note::error, "the sensor did not answer to u: it is "
                                "switched off");
    }
    if (request == Request::command) {
        notes_.add(Note::answer, text_ + ": no answer, sent " +
                                     std::to_string(event.tries) + " times");
    }
    if (!is_unheard_) {
        is_unheard_ = true;
        notes_.add(Note::warning,
                   "the sensor does not answer; it is asked again and again");
    }
    next_ns_ = now_ns;
}

void Laser::take(const lum_sensor_event &event, int64_t now_ns)
{
    switch (event.kind) {
    case LUM_SENSOR_ANSWER:
        take_answer(event, now_ns);
        break;
    case LUM_SENSOR_NO_ANSWER:
        take_no_answer(event, now_ns);
        break;
    case LUM_SENSOR_ALERT:
        next_ns_ = now_ns; // it may be older than what is known
        show_texts(event.tlvs);
        if (event.has_status) {
            take_hazard(event.status);
        }
        break;
    case LUM_SENSOR_LINK:
        notes_.add(Note::warning,
                   event.is_up
                       ? std::string("sending works again")
                       : std::string("sending fails: ") + event.error.text);
        break;
    case LUM_SENSOR_IDLE:
    case LUM_SENSOR_CANCELLED:
    case LUM_SENSOR_DATAGRAMS:
    case LUM_SENSOR_TIME:
    case LUM_SENSOR_FAILED:
        break;
    }
}

} // namespace lumsdk_ros
