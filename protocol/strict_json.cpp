#include "protocol/strict_json.h"

#include <algorithm>
#include <iterator>
#include <vector>

#include "protocol/error.h"

namespace photond {
namespace {

using nlohmann::json;

struct Position {
    size_t line = 1;
    size_t column = 0;
};

// Walks the text for nlohmann's lexer and keeps count of where it is, since the lexer tells the place of its own errors
// only.
class CountingIterator {
public:
    using iterator_category = std::input_iterator_tag;
    using value_type = char;
    using difference_type = std::ptrdiff_t;
    using pointer = const char*;
    using reference = const char&;

    CountingIterator(const char* at, Position* position) : at_(at), position_(position) {}
    reference operator*() const { return *at_; }
    CountingIterator& operator++() {
        if (*at_ == '\n') {
            ++position_->line;
            position_->column = 0;
        } else {
            ++position_->column;
        }
        ++at_;
        return *this;
    }
    CountingIterator operator++(int) {
        const CountingIterator before = *this;
        ++*this;
        return before;
    }
    bool operator==(const CountingIterator& other) const { return at_ == other.at_; }
    bool operator!=(const CountingIterator& other) const { return at_ != other.at_; }

private:
    const char* at_;
    Position* position_;
};

// Builds the document from parse events. The SAX parser is iterative, so that depth costs no stack before it is
// refused.
class StrictBuilder {
public:
    StrictBuilder(std::string_view text, const JsonLimits& limits, Position& position)
        : text_(text), limits_(limits), position_(position) {}

    bool null() { return add(nullptr); }
    bool boolean(bool value) { return add(value); }
    bool number_integer(json::number_integer_t value) { return add(value); }
    bool number_unsigned(json::number_unsigned_t value) { return add(value); }
    bool number_float(json::number_float_t value, const std::string&) { return add(value); }
    bool string(std::string& value) { return add(std::move(value)); }
    bool binary(json::binary_t&) { return false; }

    bool start_object(size_t) { return open(json::object()); }
    bool start_array(size_t) { return open(json::array()); }
    bool end_object() { return close(); }
    bool end_array() { return close(); }

    bool key(std::string& name) {
        json& object = *open_.back();
        if (object.contains(name))
            throw Error(ErrorCode::BadJson, pointer_here() + "/" + pointer_token(name),
                        "the key \"" + name + "\" appears twice in one object, " + where());
        keys_.back() = name;
        return true;
    }

    bool parse_error(size_t bytes_read, const std::string&, const nlohmann::detail::exception& error) {
        // "[json.exception.parse_error.101] parse error at line 1, column 2: syntax error while ...": we keep the last
        // part. The iterator is one character ahead behind a number, and the library's column is 0 at the end of a
        // line.
        std::string what = error.what();
        if (const size_t bracket = what.find("] "); bracket != std::string::npos) what.erase(0, bracket + 2);
        if (const size_t colon = what.find(": "); what.starts_with("parse error") && colon != std::string::npos)
            what.erase(0, colon + 2);
        if (what.size() > 300) what = what.substr(0, 300) + " ...";
        const std::string_view read = text_.substr(0, bytes_read);
        const size_t line_begin = read.rfind('\n') + 1;  // npos + 1 is 0
        position_.line = 1 + static_cast<size_t>(std::count(read.begin(), read.end(), '\n'));
        position_.column = read.size() - line_begin;
        throw Error(ErrorCode::BadJson, what + ", " + where());
    }

    json take() { return std::move(root_); }

private:
    template <class Value>
    bool add(Value&& value) {
        place(json(std::forward<Value>(value)));
        return true;
    }

    json* place(json&& value) {
        if (++values_ > limits_.max_values)
            throw Error(ErrorCode::BadJson,
                        "more than " + std::to_string(limits_.max_values) + " values in one body, " + where());
        if (open_.empty()) {
            root_ = std::move(value);
            return &root_;
        }
        json& parent = *open_.back();
        if (parent.is_array()) {
            parent.push_back(std::move(value));
            return &parent.back();
        }
        return &(parent[keys_.back()] = std::move(value));
    }

    bool open(json&& container) {
        if (open_.size() >= limits_.max_depth)
            throw Error(ErrorCode::BadJson,
                        "nested deeper than " + std::to_string(limits_.max_depth) + " levels, " + where());
        // The address stays good: a parent gets no further element before this one is closed.
        open_.push_back(place(std::move(container)));
        keys_.emplace_back();
        return true;
    }

    bool close() {
        open_.pop_back();
        keys_.pop_back();
        return true;
    }

    std::string pointer_here() const {
        std::string pointer;
        for (size_t level = 0; level + 1 < open_.size(); ++level)
            pointer += "/" + (open_[level]->is_array() ? std::to_string(open_[level]->size() - 1)
                                                       : pointer_token(keys_[level]));
        return pointer;
    }
    std::string where() const {
        return "line " + std::to_string(position_.line) + ", column " + std::to_string(position_.column);
    }

    const std::string_view text_;
    const JsonLimits& limits_;
    Position& position_;
    json root_;
    std::vector<json*> open_;
    std::vector<std::string> keys_;  // one for each open container: the member being read
    size_t values_ = 0;
};

}  // namespace

json parse_strict_json(std::string_view text, const JsonLimits& limits) {
    if (text.size() > limits.max_bytes)
        throw Error(ErrorCode::PayloadTooLarge, "the body has " + std::to_string(text.size()) +
                                                    " bytes, the limit is " + std::to_string(limits.max_bytes));
    Position position;
    StrictBuilder builder(text, limits, position);
    json::sax_parse(CountingIterator(text.data(), &position), CountingIterator(text.data() + text.size(), &position),
                    &builder);
    return builder.take();
}

std::string pointer_token(std::string_view key) {
    std::string token;
    for (const char c : key) {
        if (c == '~') {
            token += "~0";
        } else if (c == '/') {
            token += "~1";
        } else {
            token += c;
        }
    }
    return token;
}

}  // namespace photond
