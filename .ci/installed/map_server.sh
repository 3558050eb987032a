#!/usr/bin/env bash
# The map server by its launch file, with a roscore of its own, asked by rosservice.
set -euo pipefail
cd "$(mktemp -d)"
export ROS_MASTER_URI=http://127.0.0.1:11391
printf '%s\n' 'v 0 0 0' 'v 1 0 0' 'v 0 1 0' 'f 1 2 3' >face.obj
rosrun mesh_msgs_hdf5 mesh_tool import face.obj face.h5
roslaunch -p 11391 mesh_msgs_hdf5 hdf5_map_server.launch map:="$PWD/face.h5" >server.log 2>&1 &
server=$!
trap 'cat server.log; kill -INT $server' ERR
for _ in $(seq 120); do
  rosservice list 2>/dev/null | grep -q /get_uuids && break
  sleep 0.5
done
service=$(rosservice list | grep -m 1 'get_uuids$')
rosservice call "$service" | tee uuids.txt
[ "$(grep -c -e '- ' uuids.txt)" -ge 1 ]
trap - ERR
kill -INT $server
wait $server || true
