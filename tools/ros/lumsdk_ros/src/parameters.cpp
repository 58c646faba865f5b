#include "parameters.hpp"

#include <locale>
#include <sstream>
#include <stdexcept>

namespace lumsdk_ros
{

namespace
{

using Value = XmlRpc::XmlRpcValue;

[[noreturn]] void refuse(const std::string &name, const std::string &wanted)
{
    throw std::runtime_error(name + " must be " + wanted);
}

std::string number_text(double value)
{
    std::ostringstream out;
    out.imbue(std::locale::classic());
    out.precision(15);
    out << value;
    return out.str();
}

std::string scalar_text(const std::string &name, Value &value)
{
    switch (value.getType()) {
    case Value::TypeInt:
        return std::to_string(static_cast<int>(value));
    case Value::TypeDouble:
        return number_text(static_cast<double>(value));
    case Value::TypeBoolean:
        return static_cast<bool>(value) ? "true" : "false";
    case Value::TypeString:
        return static_cast<std::string &>(value);
    default:
        refuse(name, "numbers and words under keys");
    }
}

// rosparam load has made a tree of a YAML file: the library reads text, and
// knows which keys there are.
std::string tree_text(const std::string &name, Value &value, size_t depth)
{
    std::string text;
    for (auto &member : value) {
        const std::string key = name + "/" + member.first;
        text += std::string(2 * depth, ' ') + member.first + ":";
        if (member.second.getType() == Value::TypeStruct) {
            text += "\n" + tree_text(key, member.second, depth + 1);
        } else {
            text += " " + scalar_text(key, member.second) + "\n";
        }
    }
    return text;
}

std::vector<std::string> words(std::string text)
{
    std::vector<std::string> words;
    std::string word;
    for (char &c : text) {
        c = c == '[' || c == ']' || c == ',' ? ' ' : c;
    }
    std::istringstream in(text);
    while (in >> word) {
        words.push_back(word);
    }
    return words;
}

} // namespace

Parameters::Parameters(const ros::NodeHandle &node) : node_(node)
{
}

std::string Parameters::full_name(const std::string &name) const
{
    return node_.resolveName(name);
}

bool Parameters::get(const std::string &name, Value &out)
{
    asked_.insert(full_name(name));
    return node_.getParam(name, out);
}

bool Parameters::has(const std::string &name)
{
    asked_.insert(full_name(name));
    return node_.hasParam(name);
}

std::string Parameters::text(const std::string &name, const std::string &usual)
{
    Value value;
    if (!get(name, value)) {
        return usual;
    }
    if (value.getType() == Value::TypeInt) {
        return std::to_string(static_cast<int>(value));
    }
    if (value.getType() != Value::TypeString) {
        refuse(full_name(name), "a text");
    }
    return static_cast<std::string &>(value);
}

bool Parameters::flag(const std::string &name, bool usual)
{
    Value value;
    if (!get(name, value)) {
        return usual;
    }
    if (value.getType() != Value::TypeBoolean) {
        refuse(full_name(name), "true or false");
    }
    return static_cast<bool>(value);
}

double Parameters::number(const std::string &name, double usual, double least,
                          double most)
{
    Value value;
    double number = usual;
    const std::string wanted =
        "a number from " + number_text(least) + " to " + number_text(most);
    if (!get(name, value)) {
        return usual;
    }
    if (value.getType() == Value::TypeInt) {
        number = static_cast<int>(value);
    } else if (value.getType() == Value::TypeDouble) {
        number = static_cast<double>(value);
    } else {
        refuse(full_name(name), wanted);
    }
    if (!(number >= least && number <= most)) {
        refuse(full_name(name), wanted);
    }
    return number;
}

int Parameters::integer(const std::string &name, int usual, int least, int most)
{
    Value value;
    if (!get(name, value)) {
        return usual;
    }
    if (value.getType() != Value::TypeInt || static_cast<int>(value) < least ||
        static_cast<int>(value) > most) {
        refuse(full_name(name), "a whole number from " + std::to_string(least) +
                                    " to " + std::to_string(most));
    }
    return static_cast<int>(value);
}

// A list, or a text such as [points, other]: command lines give that.
std::vector<std::string> Parameters::list(const std::string &name)
{
    static const char wanted[] = "a list of texts, such as [points]";
    Value value;
    std::vector<std::string> texts;
    if (!get(name, value)) {
        return texts;
    }
    if (value.getType() == Value::TypeString) {
        return words(static_cast<std::string &>(value));
    }
    if (value.getType() != Value::TypeArray) {
        refuse(full_name(name), wanted);
    }
    for (int i = 0; i < value.size(); i++) {
        if (value[i].getType() != Value::TypeString) {
            refuse(full_name(name), wanted);
        }
        texts.push_back(static_cast<std::string &>(value[i]));
    }
    return texts;
}

bool Parameters::yaml(const std::string &name, std::string &path,
                      std::string &tree)
{
    Value value;
    path.clear();
    tree.clear();
    if (!get(name, value)) {
        return false;
    }
    if (value.getType() == Value::TypeString) {
        path = static_cast<std::string &>(value);
        return !path.empty();
    }
    if (value.getType() != Value::TypeStruct) {
        refuse(full_name(name), "a file's path, or what rosparam made of one");
    }
    tree = tree_text(full_name(name), value, 0);
    return true;
}

std::vector<std::string> Parameters::unknown() const
{
    std::vector<std::string> names;
    std::vector<std::string> strange;
    const std::string prefix = node_.getNamespace() + "/";
    (void)node_.getParamNames(names);
    for (const std::string &name : names) {
        if (name.compare(0, prefix.size(), prefix) != 0) {
            continue;
        }
        const size_t end = name.find('/', prefix.size());
        if (asked_.count(name.substr(0, end)) == 0) {
            strange.push_back(name);
        }
    }
    return strange;
}

} // namespace lumsdk_ros
