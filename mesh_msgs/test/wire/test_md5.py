"""The md5 sums that peers, bags and clients in the field depend on."""

import subprocess

import pytest
import rosmsg

import mesh_msgs.msg
import mesh_msgs.srv

MESSAGES = {
    "Feature": "ac711cf3ef6eb8582240a7afe5b9a573",
    "MeshFaceCluster": "9e0f40b9dcf1de10d00e57182c9d138f",
    "MeshFaceClusterStamped": "e9b5993e06e78f5ff36e4050fa2e88c6",
    "MeshFeatures": "ea0bfd1049bc24f2cd76d68461f1f987",
    "MeshGeometry": "9a7ed3efa2a35ef81abaf7dcc675ed20",
    "MeshGeometryStamped": "2d62dc21b3d9b8f528e4ee7f76a77fb7",
    "MeshMaterial": "6ad79583de5735994d239e1d0f34371b",
    "MeshMaterials": "e151c9a065aae90d545559129a79a70a",
    "MeshMaterialsStamped": "80683ad6336327fea277cb1ed5f58927",
    "MeshTexture": "831d05ad895f7916c0c27143f387dfa0",
    "MeshTriangleIndices": "23688b2e6d2de3d32fe8af104a903253",
    "MeshVertexColors": "2af51ba6de42b829b6f716360dfdf4d9",
    "MeshVertexColorsStamped": "9e3527729bbf26fabb162c58762b6739",
    "MeshVertexCosts": "ade4ce6a157397b6c023e12482bc76c8",
    "MeshVertexCostsSparse": "08454a2c9374a8135e4466272d6ac6ec",
    "MeshVertexCostsSparseStamped": "411233e434127bb4617f6f3bf994d8af",
    "MeshVertexCostsStamped": "f65d52b48920bc9c2a071d643ab7b6b3",
    "MeshVertexTexCoords": "4f5254e0e12914c461d4b17a0cd07f7f",
    "TriangleMesh": "b112c5b670c2c3e8b1571aae11ccc3da",
    "TriangleMeshStamped": "3e766dd12107291d682eb5e6c7442b9d",
    "VectorField": "9da8d62df10048ede4a91e419a35679d",
    "VectorFieldStamped": "3d9fc2de2c0939ad4bbe0890ccb68ce5",
    # Of this package alone; pinned so that they do not change by accident.
    "LayerInfo": "a55ef475fc2d0403ac5420fb6ec7247a",
    "LayerInfoArray": "f9e6ee5ee4b31b32b2c0023e7e0d0939",
    "LocalizationState": "3daafc79dc4218e0d82d37e1747b5706",
    "MeshFaceCosts": "ade4ce6a157397b6c023e12482bc76c8",
    "MeshFaceCostsStamped": "f24dd558c7f2de70f524aacb5ac5869b",
    "MeshLabelColors": "e17eb54bbd698f3ef2b9e6332bf5f9ca",
    "StoreResult": "436629e5aead61de852e7bd880fe1651",
}

NOTHING = "d41d8cd98f00b204e9800998ecf8427e"
UUID = "18ad0215778d252d8f14959901273e8d"
CLUSTERS = "c52c123542e7b436f7d2a518c893790c"

SERVICES = {  # service, request, response
    "DeleteLabel": (
        "291f4a1190a82bb2a4fa8742276ac1a4",
        "323a026eaec91e8dd63929aa10b99a66",
        "964931261560c5f74efcdd1a449f32de",
    ),
    "GetDerivedMesh": (  # of this package alone
        "27aca211f52498808dad7f32279d98b4",
        UUID,
        "2e2b31d2c5f8d5f4f2eae4b7a51cdd63",
    ),
    "GetGeometry": (
        "e21c42f8a3978429fcbcd1c03ddeb4e3",
        UUID,
        "835c1d1298a93c8d2adf933d065cfb24",
    ),
    "GetLabelColors": (  # of this package alone
        "f8dcdc0921d566acafdd7cf91876db7d",
        UUID,
        "874a70bf22fb7b9c63f4eceb02f66403",
    ),
    "GetLabelGroups": (
        "83c83c156bee06ca7fa5eef7a0fc9203",
        UUID,
        "17b562487ca772bdfa2c078ef00d870f",
    ),
    "GetLabeledClusterGroup": (
        "ca761f9c98d5f0693e9369657698d5a9",
        "0120c5355a36795e9319b941f3d57c83",
        CLUSTERS,
    ),
    "GetLabeledClusters": ("d4165053db3e9b1ffe9db49f0702734c", UUID, CLUSTERS),
    "GetMaterials": (
        "f9e04e76772e6c10688525f021cfc500",
        UUID,
        "c326cef5edfe0a378d5bf9479efc7487",
    ),
    "GetTexture": (
        "48823554c65f6c317f12f79207ce78ac",
        "ae69338bd730d07a68b45b525e5f35a4",
        "eb84c241b8d4afd6b255f5f17da22c7c",
    ),
    "GetUUID": (UUID, NOTHING, UUID),
    "GetUUIDs": ("7f3e5a8012f50798b9f58415835613cd", NOTHING, "7f3e5a8012f50798b9f58415835613cd"),
    "GetVertexColors": (
        "f9925939094ed9c8a413184db9bca5b3",
        UUID,
        "63811285e9a537ed83b46e6cacdd78c2",
    ),
    "GetVertexCostLayers": (
        "a986de286313bb04f65925e31f050116",
        UUID,
        "bf2354e6e282b001629817bb48bdea63",
    ),
    "GetVertexCosts": (
        "a947abb652f3b18b826e5086e2faf817",
        "6bda8d9e6686594e4c83036fd05f774a",
        "726932dec2ff29c2210dd963e3f1ecf9",
    ),
    "SetLabelColor": (  # of this package alone
        "701546d4cfc8eeb682bbad65029916bd",
        "701546d4cfc8eeb682bbad65029916bd",
        NOTHING,
    ),
}


def generated_messages():
    found = {n: c for n, c in vars(mesh_msgs.msg).items() if hasattr(c, "_md5sum")}
    return {n: c for n, c in found.items() if c.__name__ == n}  # without names of old releases


def generated_services():
    return {n: c for n, c in vars(mesh_msgs.srv).items() if hasattr(c, "_request_class")}


def test_generated_messages_have_the_sums():
    assert {name: c._md5sum for name, c in generated_messages().items()} == MESSAGES


def test_generated_services_have_the_sums():
    found = {
        name: (c._md5sum, c._request_class._md5sum, c._response_class._md5sum)
        for name, c in generated_services().items()
    }
    assert found == SERVICES


@pytest.mark.parametrize("name", sorted(MESSAGES))
def test_rosmsg_knows_the_sum(name):
    assert rosmsg.rosmsg_md5(rosmsg.MODE_MSG, "mesh_msgs/" + name) == MESSAGES[name]


@pytest.mark.parametrize("name", sorted(SERVICES))
def test_rossrv_knows_the_sum(name):
    assert rosmsg.rosmsg_md5(rosmsg.MODE_SRV, "mesh_msgs/" + name) == SERVICES[name][0]


@pytest.mark.parametrize("tool, table", [("rosmsg", MESSAGES), ("rossrv", SERVICES)])
def test_command_lists_the_types_and_prints_a_sum(tool, table):
    listed = subprocess.run([tool, "package", "mesh_msgs"], capture_output=True, check=True)
    assert listed.stdout.decode().split() == ["mesh_msgs/" + name for name in sorted(table)]
    for name in ("MeshGeometryStamped",) if table is MESSAGES else ("GetVertexCosts",):
        command = [tool, "md5", "mesh_msgs/" + name]
        printed = subprocess.run(command, capture_output=True, check=True).stdout.decode().strip()
        assert printed == (table[name] if table is MESSAGES else table[name][0])
