// A whole planner in another language: keeps to its route, and stops for red lights and whoever is
// in front. One file, no library; docs/reference/protocol-agents.md describes what is said.
//
//   g++ -O2 -std=c++17 -o my_planner examples/my_planner.cpp
//   plant-bench score --agent "command:./my_planner 8" --routes 0 --repetitions 1

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

// ---- msgpack, as much of it as the protocol needs -------------------------------------------

struct Value {
    enum Kind { NIL, NUMBER, BYTES, LIST, MAP } kind = NIL;
    double number = 0.0;
    std::string bytes;  // of texts, and of binary data
    std::vector<Value> list;
    std::map<std::string, Value> map;

    const Value &operator[](const std::string &name) const { return map.at(name); }
    bool there() const { return kind != NIL; }

    // An array: a map of "shape" and "data", raw little-endian float64.
    std::vector<double> array() const {
        const std::string &data = (*this)["data"].bytes;
        std::vector<double> values(data.size() / sizeof(double));
        std::memcpy(values.data(), data.data(), values.size() * sizeof(double));
        return values;
    }
};

class Reader {
  public:
    explicit Reader(const std::string &data) : data_(data) {}

    Value value() {
        const int tag = number(1);
        if (tag < 0x80) return of(tag);
        if (tag < 0x90) return map(tag & 0x0f);
        if (tag < 0xa0) return list(tag & 0x0f);
        if (tag < 0xc0) return bytes(tag & 0x1f);
        if (tag >= 0xe0) return of(tag - 256);
        switch (tag) {
            case 0xc0: return Value();
            case 0xc2: return of(0);
            case 0xc3: return of(1);
            case 0xc4: case 0xd9: return bytes(number(1));
            case 0xc5: case 0xda: return bytes(number(2));
            case 0xc6: case 0xdb: return bytes(number(4));
            case 0xcb: {
                const uint64_t bits = number(8);
                double real;
                std::memcpy(&real, &bits, sizeof real);
                return of(real);
            }
            case 0xcc: return of(number(1));
            case 0xcd: return of(number(2));
            case 0xce: return of(number(4));
            case 0xcf: return of(number(8));
            case 0xd0: return of(static_cast<int8_t>(number(1)));
            case 0xd1: return of(static_cast<int16_t>(number(2)));
            case 0xd2: return of(static_cast<int32_t>(number(4)));
            case 0xd3: return of(static_cast<int64_t>(number(8)));
            case 0xdc: return list(number(2));
            case 0xdd: return list(number(4));
            case 0xde: return map(number(2));
            case 0xdf: return map(number(4));
        }
        throw std::runtime_error("msgpack of an unknown kind");
    }

  private:
    uint64_t number(int size) {  // msgpack's own numbers are big-endian
        uint64_t found = 0;
        while (size-- > 0) found = found << 8 | static_cast<uint8_t>(data_.at(at_++));
        return found;
    }
    static Value of(double number) {
        Value value;
        value.kind = Value::NUMBER;
        value.number = number;
        return value;
    }
    Value bytes(size_t size) {
        if (size > data_.size() - at_) throw std::runtime_error("msgpack that ends early");
        Value value;
        value.kind = Value::BYTES;
        value.bytes = data_.substr(at_, size);
        at_ += size;
        return value;
    }
    Value list(size_t size) {
        Value value;
        value.kind = Value::LIST;
        while (size-- > 0) value.list.push_back(this->value());
        return value;
    }
    Value map(size_t size) {
        Value value;
        value.kind = Value::MAP;
        while (size-- > 0) {
            const std::string name = this->value().bytes;
            value.map[name] = this->value();
        }
        return value;
    }

    const std::string &data_;
    size_t at_ = 0;
};

std::string text(const std::string &value) {  // up to 31 bytes
    return std::string(1, static_cast<char>(0xa0 | value.size())) + value;
}

std::string real(double value) {
    uint64_t bits;
    std::memcpy(&bits, &value, sizeof bits);
    std::string out(1, static_cast<char>(0xcb));
    for (int shift = 56; shift >= 0; shift -= 8) out += static_cast<char>(bits >> shift);
    return out;
}

std::string head(int tag, size_t size) {  // of a map (0x80) or a list (0x90), up to 15 items
    return std::string(1, static_cast<char>(tag | size));
}

// ---- frames: a message's length as little-endian uint32, then the message ---------------------

bool read_frame(std::string &message) {
    uint8_t length[4];
    if (std::fread(length, 1, 4, stdin) != 4) return false;  // the benchmark has gone
    message.resize(length[0] | length[1] << 8 | length[2] << 16 | static_cast<size_t>(length[3]) << 24);
    return std::fread(&message[0], 1, message.size(), stdin) == message.size();
}

void write_frame(const std::string &message) {
    for (int shift = 0; shift < 32; shift += 8) std::putchar(static_cast<int>(message.size() >> shift & 0xff));
    std::fwrite(message.data(), 1, message.size(), stdout);
    std::fflush(stdout);
}

// ---- the planner -------------------------------------------------------------------------------

const double LOOK_AHEAD = 6;  // m along the route to steer for; its points are a metre apart
const double WHEELBASE = 2.86;  // m
const int GREEN = 1;

std::string hello() {
    return head(0x80, 3) + text("type") + text("hello") + text("protocol") + head(0, 1) +
           text("inputs") + head(0x90, 3) + text("route") + text("objects") + text("light");
}

std::string decide(const Value &seen, double gap) {
    const Value &ego = seen["ego"];
    const double x = ego["x"].number, y = ego["y"].number, yaw = ego["yaw"].number;
    double free = 50.0;
    if (seen["light"].there() && seen["light"]["state"].number != GREEN)
        free = std::max(seen["light"]["distance"].number - 1.0, 0.0);
    const std::vector<double> poses = seen["actors"]["poses"].array();
    for (size_t i = 0; i + 2 < poses.size(); i += 3) {
        const double dx = poses[i] - x, dy = poses[i + 1] - y;
        const double ahead = dx * std::cos(yaw) + dy * std::sin(yaw);
        const double aside = dy * std::cos(yaw) - dx * std::sin(yaw);
        if (ahead > 0.0 && std::abs(aside) < 2.0) free = std::min(free, ahead - gap);
    }
    const double wanted = std::min(seen["speed_limit"].number, std::sqrt(4.0 * std::max(free, 0.0)));
    const double acceleration = std::clamp(wanted - ego["speed"].number, -6.0, 2.0);
    const std::vector<double> points = seen["route"]["points"].array();
    const size_t target = std::min<size_t>(LOOK_AHEAD, points.size() / 2 - 1);
    const double dx = points[2 * target] - x, dy = points[2 * target + 1] - y;
    const double bearing = std::atan2(dy, dx) - yaw;
    const double steering = std::atan2(2.0 * WHEELBASE * std::sin(bearing), std::hypot(dx, dy));
    return head(0x80, 3) + text("type") + text("control") + text("acceleration") +
           real(acceleration) + text("steering") + real(steering);
}

int main(int count, char **words) {
    const double gap = count > 1 ? std::atof(words[1]) : 8.0;  // m between centres
    std::string message;
    while (read_frame(message)) {
        const Value question = Reader(message).value();
        const std::string type = question["type"].bytes;
        if (type == "hello") write_frame(hello());
        else if (type == "reset") write_frame(head(0x80, 1) + text("type") + text("ready"));
        else write_frame(decide(question, gap));
    }
}
