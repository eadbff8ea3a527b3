#pragma once
// What waits for a fixed number of hands, by whom it is for: clients have their turn one after another, however much
// each has waiting, and none has all places or all hands.

#include <cstddef>
#include <deque>
#include <list>
#include <optional>
#include <string>
#include <unordered_map>
#include <utility>

namespace photond::http {

struct FairQueueLimits {
    size_t waiting = 0;             // places in all
    size_t waiting_per_client = 0;  // of them one client may have
    size_t taken_per_client = 0;    // items of one client that may be in hand at once
};

/// Not thread-safe.
template <class Item>
class FairQueue {
public:
    explicit FairQueue(FairQueueLimits limits) : limits_(limits) {}

    /// False, and the item left where it is, when there is no place for it.
    bool push(const std::string& client, Item& item) {
        const auto known = clients_.find(client);
        const size_t has = known == clients_.end() ? 0 : known->second.waiting.size();
        if (size_ >= limits_.waiting || has >= limits_.waiting_per_client) return false;
        Client& of = clients_[client];
        of.waiting.push_back(std::move(item));
        if (has == 0) turns_.push_back(client);
        ++size_;
        return true;
    }

    struct Taken {
        std::string client;
        Item item;
    };
    /// The oldest item of the client whose turn it is; nothing while all that wait have as much in hand as they may.
    /// finished() must follow.
    std::optional<Taken> take() {
        for (auto turn = turns_.begin(); turn != turns_.end(); ++turn) {
            Client& of = clients_.at(*turn);
            if (of.taken >= limits_.taken_per_client) continue;
            Taken taken{std::move(*turn), std::move(of.waiting.front())};
            turns_.erase(turn);
            of.waiting.pop_front();
            ++of.taken;
            --size_;
            if (!of.waiting.empty()) turns_.push_back(taken.client);
            return taken;
        }
        return std::nullopt;
    }
    void finished(const std::string& client) {
        const auto known = clients_.find(client);
        if (--known->second.taken == 0 && known->second.waiting.empty()) clients_.erase(known);
    }

    size_t size() const { return size_; }
    void clear() {
        turns_.clear();
        for (auto& [name, client] : clients_) client.waiting.clear();
        size_ = 0;
    }

private:
    struct Client {
        std::deque<Item> waiting;
        size_t taken = 0;
    };

    const FairQueueLimits limits_;
    std::unordered_map<std::string, Client> clients_;  // those that wait or have something in hand
    std::list<std::string> turns_;                     // of those that wait
    size_t size_ = 0;
};

}  // namespace photond::http
