// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

// Registers each cloud of the topic "source" onto a map file, or onto the last cloud of the topic "target", and
// publishes the pose with its covariance and a transform. What there is to it is in scan_matcher.h and cloud_message.h,
// which need no ROS and are tested without; this file was not run (docs/ROS2.md).

#include <pcl_ssfr_ros2/cloud_message.h>
#include <pcl_ssfr_ros2/scan_matcher.h>

#include <geometry_msgs/msg/pose_with_covariance_stamped.hpp>
#include <geometry_msgs/msg/transform_stamped.hpp>
#include <rclcpp/rclcpp.hpp>
#include <sensor_msgs/msg/point_cloud2.hpp>
#include <tf2/exceptions.h>
#include <tf2_eigen/tf2_eigen.hpp>
#include <tf2_ros/buffer.h>
#include <tf2_ros/transform_broadcaster.h>
#include <tf2_ros/transform_listener.h>

#include <exception>
#include <memory>
#include <stdexcept>
#include <string>

namespace pcl_ssfr_ros2 {

namespace {

constexpr double kWaitForAnchor = 0.1; ///< the odometry of a scan may come a little after it [s]

pcl::PointCloud<pcl::PointXYZ>::Ptr
toCloud(const sensor_msgs::msg::PointCloud2& message, double least_range)
{
  CloudMessage bytes;
  bytes.height = message.height;
  bytes.width = message.width;
  for (const sensor_msgs::msg::PointField& field : message.fields)
    bytes.fields.push_back({field.name, field.offset, field.datatype, field.count});
  bytes.is_bigendian = message.is_bigendian;
  bytes.point_step = message.point_step;
  bytes.row_step = message.row_step;
  bytes.data = message.data.data();
  bytes.size = message.data.size();
  return readCloud(bytes, least_range);
}

} // namespace

class RegistrationNode : public rclcpp::Node {
public:
  RegistrationNode()
      : rclcpp::Node("pcl_ssfr_registration"), buffer_(get_clock()), listener_(buffer_), broadcaster_(*this)
  {
    MatcherConfig config;
    const auto threads = declare_parameter<int>("threads", static_cast<int>(config.threads));
    if (threads < 0)
      throw std::invalid_argument("threads = " + std::to_string(threads) + ", must be at least 0");
    config.threads = static_cast<unsigned>(threads);
    config.time_limit = declare_parameter<double>("time_limit", config.time_limit);
    config.min_confidence = declare_parameter<double>("min_confidence", config.min_confidence);
    config.gravity_tolerance = declare_parameter<double>("gravity_tolerance", config.gravity_tolerance);
    least_range_ = declare_parameter<double>("least_range", 0.1);
    target_frame_ = declare_parameter<std::string>("target_frame", "map");
    anchor_frame_ = declare_parameter<std::string>("anchor_frame", "");
    publish_transform_ = declare_parameter<bool>("publish_transform", true);
    const auto map_file = declare_parameter<std::string>("map_file", "");
    matcher_ = std::make_unique<ScanMatcher>(config);

    publisher_ = create_publisher<geometry_msgs::msg::PoseWithCovarianceStamped>("pose", rclcpp::QoS(1));
    // One cloud waits, no more: the newest is worth more than all.
    const rclcpp::QoS newest = rclcpp::SensorDataQoS().keep_last(1);
    if (map_file.empty())
      target_subscription_ = create_subscription<sensor_msgs::msg::PointCloud2>(
          "target", newest, [this](sensor_msgs::msg::PointCloud2::ConstSharedPtr message) { onTarget(*message); });
    else
      matcher_->setTarget(*readMap(map_file));
    source_subscription_ = create_subscription<sensor_msgs::msg::PointCloud2>(
        "source", newest, [this](sensor_msgs::msg::PointCloud2::ConstSharedPtr message) { onSource(*message); });
  }

private:
  void
  onTarget(const sensor_msgs::msg::PointCloud2& message)
  {
    try {
      matcher_->setTarget(*toCloud(message, least_range_));
      target_frame_ = message.header.frame_id;
    }
    catch (const std::invalid_argument& error) {
      RCLCPP_ERROR(get_logger(), "target: %s", error.what());
    }
  }

  void
  onSource(const sensor_msgs::msg::PointCloud2& message)
  {
    try {
      const Match match = matcher_->match(*toCloud(message, least_range_));
      if (match.accepted)
        publish(match, message.header);
      else
        RCLCPP_WARN(get_logger(), "not accepted: %s", match.message.c_str());
    }
    catch (const std::invalid_argument& error) {
      RCLCPP_ERROR(get_logger(), "source: %s", error.what());
    }
    catch (const tf2::TransformException& error) {
      RCLCPP_ERROR(get_logger(), "anchor_frame: %s", error.what());
    }
  }

  void
  publish(const Match& match, const std_msgs::msg::Header& source)
  {
    geometry_msgs::msg::PoseWithCovarianceStamped pose;
    pose.header.stamp = source.stamp;
    pose.header.frame_id = target_frame_;
    pose.pose.pose = tf2::toMsg(match.T_target_source);
    pose.pose.covariance = toRowMajor(match.covariance);
    publisher_->publish(pose);
    if (!publish_transform_)
      return;

    Eigen::Isometry3d T_target_child = match.T_target_source;
    if (!anchor_frame_.empty())
      T_target_child =
          anchored(T_target_child,
                   tf2::transformToEigen(buffer_.lookupTransform(anchor_frame_,
                                                                 source.frame_id,
                                                                 rclcpp::Time(source.stamp),
                                                                 rclcpp::Duration::from_seconds(kWaitForAnchor))));
    geometry_msgs::msg::TransformStamped transform = tf2::eigenToTransform(T_target_child);
    transform.header = pose.header;
    transform.child_frame_id = anchor_frame_.empty() ? source.frame_id : anchor_frame_;
    broadcaster_.sendTransform(transform);
  }

  double least_range_ = 0;
  std::string target_frame_;
  std::string anchor_frame_;
  bool publish_transform_ = true;
  std::unique_ptr<ScanMatcher> matcher_;
  tf2_ros::Buffer buffer_;
  tf2_ros::TransformListener listener_;
  tf2_ros::TransformBroadcaster broadcaster_;
  rclcpp::Publisher<geometry_msgs::msg::PoseWithCovarianceStamped>::SharedPtr publisher_;
  rclcpp::Subscription<sensor_msgs::msg::PointCloud2>::SharedPtr target_subscription_;
  rclcpp::Subscription<sensor_msgs::msg::PointCloud2>::SharedPtr source_subscription_;
};

} // namespace pcl_ssfr_ros2

int
main(int argc, char** argv)
{
  rclcpp::init(argc, argv);
  int code = 0;
  try {
    rclcpp::spin(std::make_shared<pcl_ssfr_ros2::RegistrationNode>());
  }
  catch (const std::exception& error) {
    RCLCPP_FATAL(rclcpp::get_logger("pcl_ssfr_registration"), "%s", error.what());
    code = 1;
  }
  rclcpp::shutdown();
  return code;
}
