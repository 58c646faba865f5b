// reader [OPTION]... TOPIC TYPE: reads a topic by Fast DDS, the library under ROS 2's default middleware, without a
// decoder: samples are bytes in CDR. Prints a JSON object a line: a writer that was found, a sample with its age since it
// was written and since its header's stamp, the end.
//   --domain N   (default 0)
//   --count N    ends after so many samples (default: at the signal TERM)
//   --best-effort, --latched   what it asks for; default: reliable, volatile
//   --depth N    samples that wait in it (default 5)
//   --buffer N   bytes of its sockets' receive buffers, as far as net.core.rmem_max allows (default: the system's)
//   --slow MS    so long for each sample
//   --out DIR    each sample into a file, 0.cdr, 1.cdr, ...
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/domain/DomainParticipantListener.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/Topic.hpp>
#include <fastdds/dds/topic/TopicDataType.hpp>

#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace fast = eprosima::fastdds::dds;
namespace rtps = eprosima::fastrtps::rtps;

namespace {

using Bytes = std::vector<unsigned char>;

std::atomic<bool> is_ended{false};
std::mutex output;

class RawType : public fast::TopicDataType {
public:
    explicit RawType(const std::string &name)
    {
        setName(name.c_str());
        m_typeSize = 4096; // grows with what comes
        m_isGetKeyDefined = false;
        auto_fill_type_information(false);
        auto_fill_type_object(false);
    }

    bool serialize(void *, rtps::SerializedPayload_t *) override { return false; }

    bool deserialize(rtps::SerializedPayload_t *payload, void *data) override
    {
        static_cast<Bytes *>(data)->assign(payload->data, payload->data + payload->length);
        return true;
    }

    std::function<uint32_t()> getSerializedSizeProvider(void *data) override
    {
        return [data]() { return static_cast<uint32_t>(static_cast<Bytes *>(data)->size()); };
    }

    void *createData() override { return new Bytes; }
    void deleteData(void *data) override { delete static_cast<Bytes *>(data); }
    bool getKey(void *, rtps::InstanceHandle_t *, bool) override { return false; }
};

class Discovery : public fast::DomainParticipantListener {
public:
    explicit Discovery(std::string topic) : topic_(std::move(topic)) {}

    void on_publisher_discovery(fast::DomainParticipant *, rtps::WriterDiscoveryInfo &&found) override
    {
        const auto &proxy = found.info;
        if (proxy.topicName() != topic_.c_str()) {
            return;
        }
        std::string user;
        for (const auto byte : proxy.m_qos.m_userData.getValue()) {
            user += static_cast<char>(byte);
        }
        const bool has_left = found.status == rtps::WriterDiscoveryInfo::REMOVED_WRITER;
        const std::lock_guard<std::mutex> lock(output);
        std::printf("{\"writer\": \"%s\", \"type\": \"%s\", \"user_data\": \"%s\", \"reliable\": %s, \"latched\": %s}\n",
                    has_left ? "left" : "found", proxy.typeName().c_str(), user.c_str(),
                    proxy.m_qos.m_reliability.kind == fast::RELIABLE_RELIABILITY_QOS ? "true" : "false",
                    proxy.m_qos.m_durability.kind == fast::TRANSIENT_LOCAL_DURABILITY_QOS ? "true" : "false");
        std::fflush(stdout);
    }

private:
    std::string topic_;
};

struct Options {
    unsigned domain = 0;
    unsigned long count = 0;
    int depth = 5;
    int slow_ms = 0;
    unsigned buffer = 0;
    bool is_reliable = true;
    bool is_latched = false;
    std::string out;
    std::string topic;
    std::string type;
};

Options parse(int argc, char **argv)
{
    Options o;
    std::vector<std::string> words;
    for (int i = 1; i < argc; i++) {
        const std::string word = argv[i];
        const auto value = [&]() { return i + 1 < argc ? argv[++i] : ""; };
        if (word == "--domain") {
            o.domain = static_cast<unsigned>(std::atoi(value()));
        } else if (word == "--count") {
            o.count = std::strtoul(value(), nullptr, 10);
        } else if (word == "--depth") {
            o.depth = std::atoi(value());
        } else if (word == "--slow") {
            o.slow_ms = std::atoi(value());
        } else if (word == "--buffer") {
            o.buffer = static_cast<unsigned>(std::atoi(value()));
        } else if (word == "--out") {
            o.out = value();
        } else if (word == "--best-effort") {
            o.is_reliable = false;
        } else if (word == "--latched") {
            o.is_latched = true;
        } else {
            words.push_back(word);
        }
    }
    if (words.size() != 2) {
        std::fprintf(stderr, "reader [OPTION]... TOPIC TYPE\n");
        std::exit(2);
    }
    o.topic = words[0];
    o.type = words[1];
    return o;
}

fast::DataReaderQos reader_qos(const Options &o)
{
    fast::DataReaderQos qos = fast::DATAREADER_QOS_DEFAULT;
    qos.reliability().kind = o.is_reliable ? fast::RELIABLE_RELIABILITY_QOS : fast::BEST_EFFORT_RELIABILITY_QOS;
    qos.durability().kind = o.is_latched ? fast::TRANSIENT_LOCAL_DURABILITY_QOS : fast::VOLATILE_DURABILITY_QOS;
    qos.history().kind = fast::KEEP_LAST_HISTORY_QOS;
    qos.history().depth = o.depth;
    qos.endpoint().history_memory_policy = rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE; // as ROS 2 has it
    return qos;
}

void keep(const Options &o, unsigned long n, const Bytes &bytes)
{
    if (!o.out.empty()) {
        std::ofstream(o.out + "/" + std::to_string(n) + ".cdr", std::ios::binary)
            .write(reinterpret_cast<const char *>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    }
}

long since_us(long long ns)
{
    using namespace std::chrono;
    return static_cast<long>((duration_cast<nanoseconds>(system_clock::now().time_since_epoch()).count() - ns) / 1000);
}

// Of a message that begins with a header, in CDR of little-endian order.
long long stamp_ns(const Bytes &bytes)
{
    unsigned long long words = 0;
    for (size_t i = 0; i < 8 && bytes.size() >= 12; i++) {
        words |= static_cast<unsigned long long>(bytes[4 + i]) << (8 * i);
    }
    return static_cast<long long>(words & 0xffffffffu) * 1000000000 + static_cast<long long>(words >> 32);
}

enum class Taken { nothing, something, sample };

// A sample that a newer one replaced meanwhile is empty.
Taken take(fast::DataReader &reader, Bytes &bytes, fast::SampleInfo &info)
{
    bytes.clear();
    if (reader.take_next_sample(&bytes, &info) != eprosima::fastrtps::types::ReturnCode_t::RETCODE_OK) {
        return Taken::nothing;
    }
    return info.valid_data && !bytes.empty() ? Taken::sample : Taken::something;
}

void tell(unsigned long n, const Bytes &bytes, const fast::SampleInfo &info)
{
    const std::lock_guard<std::mutex> lock(output);
    std::printf("{\"sample\": %lu, \"bytes\": %zu, \"age_us\": %ld, \"stamp_age_us\": %ld, \"sequence\": %llu}\n", n, bytes.size(),
                since_us(info.source_timestamp.to_ns()), since_us(stamp_ns(bytes)),
                static_cast<unsigned long long>(info.sample_identity.sequence_number().to64long()));
    std::fflush(stdout);
}

unsigned long read_all(fast::DataReader &reader, const Options &o)
{
    unsigned long n = 0;
    Bytes bytes;
    while (!is_ended && (o.count == 0 || n < o.count)) {
        fast::SampleInfo info;
        Taken taken = take(reader, bytes, info);
        if (taken == Taken::sample) {
            tell(n, bytes, info);
            keep(o, n++, bytes);
            std::this_thread::sleep_for(std::chrono::milliseconds(o.slow_ms));
        } else if (taken == Taken::nothing) {
            reader.wait_for_unread_message({0, 100000000});
        }
    }
    return n;
}

void end(int) { is_ended = true; }

} // namespace

int main(int argc, char **argv)
{
    const Options o = parse(argc, argv);
    std::signal(SIGTERM, end);
    std::signal(SIGINT, end);
    Discovery discovery(o.topic);
    auto *factory = fast::DomainParticipantFactory::get_instance();
    fast::DomainParticipantQos qos = fast::PARTICIPANT_QOS_DEFAULT;
    if (o.buffer != 0) {
        qos.transport().listen_socket_buffer_size = o.buffer;
    }
    auto *participant = factory->create_participant(o.domain, qos, &discovery,
                                                    fast::StatusMask::none());
    fast::TypeSupport type(new RawType(o.type));
    if (participant == nullptr || type.register_type(participant) != eprosima::fastrtps::types::ReturnCode_t::RETCODE_OK) {
        return 1;
    }
    auto *topic = participant->create_topic(o.topic, o.type, fast::TOPIC_QOS_DEFAULT);
    auto *subscriber = participant->create_subscriber(fast::SUBSCRIBER_QOS_DEFAULT);
    auto *reader = subscriber->create_datareader(topic, reader_qos(o));
    if (reader == nullptr) {
        return 1;
    }
    std::printf("{\"ready\": true}\n");
    std::fflush(stdout);
    const unsigned long n = read_all(*reader, o);
    std::printf("{\"end\": %lu}\n", n);
    participant->delete_contained_entities();
    factory->delete_participant(participant);
    return 0;
}
