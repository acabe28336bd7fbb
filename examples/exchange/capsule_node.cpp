/* A capsule as a node of ROS 2, which moves it on under the drive that it hears.

   vibrocap export examples/travels-by-stick-slip.toml --to c --input drive --out capsule
   (capsule.c and this file are the sources of an executable of a package that depends on rclcpp and std_msgs)

   Hears "drive" (std_msgs/Float64), which is held until the next one. Tells "state" (std_msgs/Float64MultiArray: time,
   states and observables in the order of capsule.h, sides) a hundred times a second, and "event" (std_msgs/String) for
   every event at the end of the step in which it was. All in the units of the case, s where it is in SI. */
#include <chrono>
#include <memory>
#include <string>

#include "capsule.h"
#include "rclcpp/rclcpp.hpp"
#include "std_msgs/msg/float64.hpp"
#include "std_msgs/msg/float64_multi_array.hpp"
#include "std_msgs/msg/string.hpp"

using namespace std::chrono_literals;

class CapsuleNode : public rclcpp::Node {
 public:
  CapsuleNode() : Node("capsule") {
    capsule_case(&motion_);
    capsule_begin(&motion_);
    state_ = create_publisher<std_msgs::msg::Float64MultiArray>("state", 10);
    event_ = create_publisher<std_msgs::msg::String>("event", 10);
    drive_ = create_subscription<std_msgs::msg::Float64>(
        "drive", 10, [this](std_msgs::msg::Float64::ConstSharedPtr heard) { set_drive(heard->data); });
    timer_ = create_wall_timer(10ms, [this] { step(0.01); });
  }

 private:
  void set_drive(double value) {
    if (!capsule_set_input(&motion_, value / capsule_input_info(0)->scale, 0.0, 0.0))
      RCLCPP_WARN(get_logger(), "the drive is not a finite number and is left as it was");
  }

  void step(double seconds) {
    const double unit = capsule_time_info()->scale, end = capsule_time(&motion_) + seconds / unit;
    int status = CAPSULE_AT_EVENT;
    while (status == CAPSULE_AT_EVENT && end > capsule_time(&motion_)) {
      status = capsule_step_to_event(&motion_, end - capsule_time(&motion_));
      if (status == CAPSULE_AT_EVENT) tell_event();
    }
    tell_state();
    if (status == CAPSULE_RUNNING || status == CAPSULE_AT_EVENT) return;
    RCLCPP_ERROR(get_logger(), "the motion has ended: %s", capsule_status_text(status));
    timer_->cancel();
  }

  void tell_event() {
    double time;
    int kind, contact;
    capsule_last_event(&motion_, &time, &kind, &contact);
    std_msgs::msg::String told;
    told.data = std::string(capsule_event_name(kind)) + " of contact " + std::to_string(contact) + " at " +
                std::to_string(time * capsule_time_info()->scale);
    event_->publish(told);
  }

  void tell_state() {
    const double *now = capsule_look(&motion_);
    std_msgs::msg::Float64MultiArray told;
    told.data.push_back(capsule_time(&motion_) * capsule_time_info()->scale);
    for (int i = 0; i < CAPSULE_STATES; i++) told.data.push_back(now[i] * capsule_state_info(i)->scale);
    for (int i = 0; i < CAPSULE_OBSERVABLES; i++)
      told.data.push_back(now[CAPSULE_STATES + i] * capsule_observable_info(i)->scale);
    for (int i = 1; i <= CAPSULE_CONTACTS; i++) told.data.push_back(capsule_side(&motion_, i));
    state_->publish(told);
  }

  capsule motion_;
  rclcpp::Publisher<std_msgs::msg::Float64MultiArray>::SharedPtr state_;
  rclcpp::Publisher<std_msgs::msg::String>::SharedPtr event_;
  rclcpp::Subscription<std_msgs::msg::Float64>::SharedPtr drive_;
  rclcpp::TimerBase::SharedPtr timer_;
};

int main(int argc, char **argv) {
  rclcpp::init(argc, argv);
  rclcpp::spin(std::make_shared<CapsuleNode>());
  rclcpp::shutdown();
  return 0;
}
