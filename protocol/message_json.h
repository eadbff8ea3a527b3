#pragma once
// Messages as JSON objects and back. A message is a struct with the name of its type, kType, and one function visit()
// that shows each of its members to a visitor, by name; a part of a message is such a struct without a type. Writing
// and reading are the two visitors.
//
// Reading is total: a scene may have taken a worker over, and then its messages say anything. Whatever is not as the
// struct has it is an Error that names the message and, by a JSON pointer, the member: ErrorCode::MissingField,
// WrongType or OutOfRange. Members that the struct does not have are left unread.

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "protocol/error.h"

namespace photond {

/// Goes through the members of a message with the values to write or to read in place. A value is a truth value, a
/// number, text, a path, JSON that is passed through unread, a part, or a list of these.
class MessageVisitor {
public:
    virtual ~MessageVisitor() = default;

    /// A member that is always there.
    template <class Value>
    void member(const char* name, Value& value) {
        visit_member(name, Presence::Always, value);
    }
    /// One that whoever writes may leave out: the value then stays what the struct has by default.
    template <class Value>
    void or_default(const char* name, Value& value) {
        visit_member(name, Presence::Known, value);
    }
    /// One that is null where it is empty: a std::optional, JSON, or text that is never of no length.
    template <class Value>
    void or_null(const char* name, Value& value) {
        visit_member(name, is_empty(value) ? Presence::Null : Presence::Known, value);
    }
    /// One that is left out where it is empty.
    template <class Value>
    void if_any(const char* name, Value& value) {
        visit_member(name, is_empty(value) ? Presence::LeftOut : Presence::Known, value);
    }

    /// The value at hand.
    template <class Value>
    void visit_value(Value& value) {
        if constexpr (requires { value.visit(*this); }) {
            begin_object();
            value.visit(*this);
        } else {
            scalar(value);
        }
    }
    template <class Value>
    void visit_value(std::optional<Value>& value) {
        // Not emplace(): clang does not take a nested struct with default members for constructible there.
        if (!value) value = Value{};
        visit_value(*value);
    }
    template <class Element>
    void visit_value(std::vector<Element>& list) {
        list.resize(begin_list(list.size()));
        for (size_t i = 0; i < list.size(); ++i) {
            enter_element(i);
            visit_value(list[i]);
            leave();
        }
    }

protected:
    /// Known: it has a value, or may have one. A reader takes all but the first alike, for what it reads into is empty.
    enum class Presence : uint8_t { Always, Known, Null, LeftOut };

    /// Goes to a member of the object at hand; false where there is no value to visit, and leave() is not called then.
    virtual bool enter(const char* name, Presence presence) = 0;
    virtual void enter_element(size_t index) = 0;
    virtual void leave() = 0;
    virtual void begin_object() = 0;
    /// The length of the list at hand; `size` is that of the one to write.
    virtual size_t begin_list(size_t size) = 0;
    virtual void scalar(bool& value) = 0;
    virtual void scalar(uint32_t& value) = 0;
    virtual void scalar(uint64_t& value) = 0;
    virtual void scalar(int64_t& value) = 0;
    virtual void scalar(double& value) = 0;
    virtual void scalar(std::string& value) = 0;
    virtual void scalar(std::filesystem::path& value) = 0;
    virtual void scalar(nlohmann::json& value) = 0;

private:
    template <class Value>
    void visit_member(const char* name, Presence presence, Value& value) {
        if (!enter(name, presence)) return;
        visit_value(value);
        leave();
    }
    template <class Value>
    static bool is_empty(const std::optional<Value>& value) {
        return !value.has_value();
    }
    static bool is_empty(const std::string& value) { return value.empty(); }
    static bool is_empty(const std::filesystem::path& value) { return value.empty(); }
    static bool is_empty(const nlohmann::json& value) { return value.is_null(); }
};

/// Writes values into a JSON value; long ones are moved there.
class MessageWriter final : public MessageVisitor {
public:
    explicit MessageWriter(nlohmann::json& target) : at_{&target} {}

private:
    bool enter(const char* name, Presence presence) override;
    void enter_element(size_t index) override;
    void leave() override { at_.pop_back(); }
    void begin_object() override;
    size_t begin_list(size_t size) override;
    void scalar(bool& value) override;
    void scalar(uint32_t& value) override;
    void scalar(uint64_t& value) override;
    void scalar(int64_t& value) override;
    void scalar(double& value) override;
    void scalar(std::string& value) override;
    void scalar(std::filesystem::path& value) override;
    void scalar(nlohmann::json& value) override;

    std::vector<nlohmann::json*> at_;  // the value at hand last
};

/// Reads values, which are empty before, from a JSON value. `what` names the message in errors.
class MessageReader final : public MessageVisitor {
public:
    MessageReader(const nlohmann::json& source, std::string_view what) : what_(what), at_{&source} {}

private:
    bool enter(const char* name, Presence presence) override;
    void enter_element(size_t index) override;
    void leave() override;
    void begin_object() override;
    size_t begin_list(size_t size) override;
    void scalar(bool& value) override;
    void scalar(uint32_t& value) override;
    void scalar(uint64_t& value) override;
    void scalar(int64_t& value) override;
    void scalar(double& value) override;
    void scalar(std::string& value) override;
    void scalar(std::filesystem::path& value) override;
    void scalar(nlohmann::json& value) override;

    void go_to(const nlohmann::json& value, const std::string& token);
    template <class Integer>
    void read_integer(Integer& value) const;
    [[noreturn]] void fail(ErrorCode code, const std::string& fault) const;
    [[noreturn]] void fail_type(const char* wanted) const;

    const std::string_view what_;
    std::vector<const nlohmann::json*> at_;  // the value at hand last
    std::vector<size_t> pointer_lengths_;    // before each step
    std::string pointer_;                    // of the value at hand
};

/// The type that a message says it is of; of no length where it says none.
std::string_view type_of_message(const nlohmann::json& message);
void set_type_of_message(nlohmann::json& message, const char* type);

/// Adds a part's members to an object that has others.
template <class Part>
void add_members(nlohmann::json& object, Part part) {
    MessageWriter(object).visit_value(part);
}

template <class Part>
nlohmann::json part_json(Part part) {
    nlohmann::json written;
    add_members(written, std::move(part));
    return written;
}
/// Null where there is none.
template <class Part>
nlohmann::json part_json(std::optional<Part> part) {
    return part ? part_json(*std::move(part)) : nlohmann::json();
}

/// Throws Error; `what` is the message in which the part is.
template <class Part>
Part read_part(const nlohmann::json& source, std::string_view what) {
    Part part;
    MessageReader(source, what).visit_value(part);
    return part;
}

template <class Message>
nlohmann::json message_json(Message message) {
    nlohmann::json written = part_json(std::move(message));
    set_type_of_message(written, Message::kType);
    return written;
}

template <class Message>
bool is_message(const nlohmann::json& message) {
    return type_of_message(message) == Message::kType;
}

/// Empty where the message is of another type. Throws Error where it is of this one and cannot be read.
template <class Message>
std::optional<Message> message_as(const nlohmann::json& message) {
    if (!is_message<Message>(message)) return std::nullopt;
    return read_part<Message>(message, Message::kType);
}

/// Whichever of these a message is: empty where it is none. Throws Error where it cannot be read.
template <class... Messages>
std::optional<std::variant<Messages...>> message_among(const nlohmann::json& message,
                                                       std::type_identity<std::variant<Messages...>>) {
    std::optional<std::variant<Messages...>> found;
    const auto try_type = [&]<class Message>(std::type_identity<Message>) {
        if (!found && is_message<Message>(message)) found = read_part<Message>(message, Message::kType);
    };
    (try_type(std::type_identity<Messages>()), ...);
    return found;
}

}  // namespace photond
