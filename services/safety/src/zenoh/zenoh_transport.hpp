// The gate on Zenoh, through the zenoh-c API. The only file that knows Zenoh is its .cpp.
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <string>

#include "fairlead_safety/gate.hpp"
#include "process/outlet.hpp"
#include "zenoh/key_table.hpp"
#include "zenoh/zenoh_config.hpp"

namespace fairlead {

/// One Zenoh session. Handlers run on Zenoh's receive threads, several at once; events of one
/// session and key arrive in order.
class ZenohTransport final : public Outlet {
 public:
  using Handler = std::function<void(const Event&, Answer*)>;
  /// Called every two seconds while a client's router cannot be reached; may throw to give up.
  using OnWait = std::function<void()>;

  /// Opens the session and declares the publishers that do not depend on a source.
  /// Throws StartFailed, naming a port that is taken.
  ZenohTransport(const Endpoints& endpoints, KeyTable keys, const OnWait& on_wait);
  /// Waits for running handlers; must not be called from one.
  ~ZenohTransport() override;

  /// Whether leases of another gate for this robot arrive within `patience`.
  bool hears_another_gate(std::chrono::milliseconds patience);
  /// Subscribe and answer queries from now on.
  void listen(Handler handler);
  /// Declare the liveliness token that tools wait for.
  void announce(const std::string& service);
  /// Stop listening: no handler runs when this returns. Publishing still works.
  void stop_listening();

  bool prepare_source(std::string_view source, bool& is_new) override;
  void forget_source(std::string_view source) override;
  void publish(OutputKind kind, const Name& source, Bytes payload, Leaves when) override;

 private:
  class Session;
  std::unique_ptr<Session> session_;
};

}  // namespace fairlead
