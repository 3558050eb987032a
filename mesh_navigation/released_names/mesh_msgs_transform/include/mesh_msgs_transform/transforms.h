#ifndef MESH_MSGS_TRANSFORM_TRANSFORMS_H
#define MESH_MSGS_TRANSFORM_TRANSFORMS_H

#include <mesh_msgs/MeshGeometryStamped.h>
#include <mesh_msgs/TriangleMeshStamped.h>
#include <ros/console.h>
#include <tf/tf.h>

#include <string>
#include <vector>

/// Meshes in another frame, by the released names. Ours for Python: mesh_msgs.transform.
namespace mesh_msgs_transform {
namespace detail {
/// Whether tf knows the way; what it says if not goes to the log.
template <typename Lookup>
bool lookedUp(const Lookup& lookup)
{
  try {
    lookup();
    return true;
  } catch (const tf::TransformException& error) {
    ROS_ERROR_STREAM("a mesh cannot be transformed: " << error.what());
    return false;
  }
}

inline void move(std::vector<geometry_msgs::Point>& points, const tf::Matrix3x3& rotation,
                 const tf::Vector3& translation)
{
  for (geometry_msgs::Point& point : points) {
    const tf::Vector3 moved = rotation * tf::Vector3(point.x, point.y, point.z) + translation;
    point.x = moved.x();
    point.y = moved.y();
    point.z = moved.z();
  }
}

/// Vertices are rotated and shifted, normals rotated.
template <typename Mesh>
void moveMesh(Mesh& mesh, const tf::StampedTransform& transform)
{
  const tf::Matrix3x3 rotation(transform.getRotation());
  move(mesh.vertices, rotation, transform.getOrigin());
  move(mesh.vertex_normals, rotation, tf::Vector3(0, 0, 0));
}

template <typename Stamped, typename Member>
bool transformed(const std::string& target_frame, const ros::Time& target_time,
                 const Stamped& mesh_in, const ros::Time& source_time,
                 const std::string& fixed_frame, Stamped& mesh_out,
                 const tf::Transformer& tf_listener, Member mesh)
{
  tf::StampedTransform transform;
  const auto lookup = [&] {
    tf_listener.lookupTransform(target_frame, target_time, mesh_in.header.frame_id, source_time,
                                fixed_frame, transform);
  };
  if (!lookedUp(lookup)) {
    return false;
  }
  mesh_out = mesh_in;
  moveMesh(mesh_out.*mesh, transform);
  mesh_out.header.frame_id = target_frame;
  return true;
}
}  // namespace detail

/// The mesh in target_frame, by the newest transforms, along fixed_frame.
///
/// mesh_out may be mesh_in. It has the UUID and the stamp of mesh_in (release 1.1 left the UUID
/// out, and set the time of the call).
///
/// @return false, with a line in the log and mesh_out as it was, if tf does not know the way.
inline bool transformGeometryMeshNoTime(const std::string& target_frame,
                                        const mesh_msgs::MeshGeometryStamped& mesh_in,
                                        const std::string& fixed_frame,
                                        mesh_msgs::MeshGeometryStamped& mesh_out,
                                        const tf::Transformer& tf_listener)
{
  return detail::transformed(target_frame, ros::Time(0), mesh_in, ros::Time(0), fixed_frame,
                             mesh_out, tf_listener, &mesh_msgs::MeshGeometryStamped::mesh_geometry);
}

/// The same of the mesh of release 1.0.
inline bool transformTriangleMeshNoTime(const std::string& target_frame,
                                        const mesh_msgs::TriangleMeshStamped& mesh_in,
                                        const std::string& fixed_frame,
                                        mesh_msgs::TriangleMeshStamped& mesh_out,
                                        const tf::Transformer& tf_listener)
{
  return detail::transformed(target_frame, ros::Time(0), mesh_in, ros::Time(0), fixed_frame,
                             mesh_out, tf_listener, &mesh_msgs::TriangleMeshStamped::mesh);
}

/// The same, from where mesh_in was at its stamp to where target_frame is at target_time, which is
/// the stamp of mesh_out then.
inline bool transformTriangleMesh(const std::string& target_frame, const ros::Time& target_time,
                                  const mesh_msgs::TriangleMeshStamped& mesh_in,
                                  const std::string& fixed_frame,
                                  mesh_msgs::TriangleMeshStamped& mesh_out,
                                  const tf::Transformer& tf_listener)
{
  if (!detail::transformed(target_frame, target_time, mesh_in, mesh_in.header.stamp, fixed_frame,
                           mesh_out, tf_listener, &mesh_msgs::TriangleMeshStamped::mesh)) {
    return false;
  }
  mesh_out.header.stamp = target_time;
  return true;
}

}  // namespace mesh_msgs_transform

#endif
