#pragma once
// Embree by its C interface alone: the yardstick of path_tracing_bench. All triangles lie in world space in one scene,
// also those that the renderer's own intersector places by Embree instances, and rays are traced that were laid out for
// Embree beforehand. The scene is robust, as the renderer's is.

#include <embree3/rtcore.h>

#include <cstring>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "renderer/core/parallel.h"
#include "renderer/scene/intersector.h"
#include "renderer/scene/scene.h"
#include "renderer/scene/surface_color.h"

namespace photond {

/// Rays that were asked for together, and what they met.
struct RecordedBatch {
    std::vector<Ray> rays;
    Coherence coherence;
    bool shadow;
    size_t blocked;  // rays that met something
};

class BareEmbree {
public:
    static constexpr size_t kPacket = 8;

    /// Prepares all batches, whose rays are traced as they stand: in packets and one by one.
    BareEmbree(const Scene& scene, const std::vector<RecordedBatch>& recorded)
        : device_(rtcNewDevice(nullptr)), embree_scene_(rtcNewScene(device_)) {
        rtcSetSceneFlags(embree_scene_, RTC_SCENE_FLAG_ROBUST);
        surfaces_.reserve(scene.instances.size());
        for (uint32_t i = 0; i < scene.instances.size(); ++i) add_instance(scene, i);
        rtcCommitScene(embree_scene_);
        if (rtcGetDeviceError(device_) != RTC_ERROR_NONE) throw std::runtime_error("Embree does not build the scene");
        for (const RecordedBatch& batch : recorded) batches_.push_back(lay_out(batch));
    }
    ~BareEmbree() {
        rtcReleaseScene(embree_scene_);
        rtcReleaseDevice(device_);
    }
    BareEmbree(const BareEmbree&) = delete;

    /// Packets of eight, each copied from its prepared state to the stack and traced there.
    void trace_packets() const {
        parallel_for(batches_.size(), 1, [&](size_t i) {
            const Batch& batch = batches_[i];
            RTCIntersectContext context = context_of(batch);
            RTCRayHit8 query;
            for (const Packet& packet : batch.packets) {
                query.ray = packet.ray;
                if (batch.shadow) {
                    rtcOccluded8(packet.valid, embree_scene_, &context, &query.ray);
                } else {
                    std::memset(query.hit.geomID, 0xff, sizeof query.hit.geomID);  // RTC_INVALID_GEOMETRY_ID
                    rtcIntersect8(packet.valid, embree_scene_, &context, &query);
                }
                __asm__ volatile("" : : "r"(&query) : "memory");  // somebody reads the answer
            }
        });
    }

    /// Rays one by one.
    void trace_singles() const {
        parallel_for(batches_.size(), 1, [&](size_t i) {
            const Batch& batch = batches_[i];
            RTCIntersectContext context = context_of(batch);
            RTCRayHit query;
            for (const RTCRay& ray : batch.singles) {
                query.ray = ray;
                if (batch.shadow) {
                    rtcOccluded1(embree_scene_, &context, &query.ray);
                } else {
                    query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
                    rtcIntersect1(embree_scene_, &context, &query);
                }
                __asm__ volatile("" : : "r"(&query) : "memory");
            }
        });
    }

    /// Throws unless the rays meet what they met when they were recorded, but for one in 10,000 (rounding).
    void check(const std::vector<RecordedBatch>& recorded) const {
        size_t rays = 0, difference = 0;
        for (size_t i = 0; i < batches_.size(); ++i) {
            RTCIntersectContext context = context_of(batches_[i]);
            size_t blocked = 0;
            for (const Packet& packet : batches_[i].packets) {
                RTCRayHit8 query{.ray = packet.ray, .hit = {}};
                std::memset(query.hit.geomID, 0xff, sizeof query.hit.geomID);
                if (recorded[i].shadow)
                    rtcOccluded8(packet.valid, embree_scene_, &context, &query.ray);
                else
                    rtcIntersect8(packet.valid, embree_scene_, &context, &query);
                for (size_t lane = 0; lane < kPacket; ++lane)
                    blocked +=
                        packet.valid[lane] && (recorded[i].shadow ? query.ray.tfar[lane] < 0
                                                                  : query.hit.geomID[lane] != RTC_INVALID_GEOMETRY_ID);
            }
            rays += recorded[i].rays.size();
            difference += blocked > recorded[i].blocked ? blocked - recorded[i].blocked : recorded[i].blocked - blocked;
        }
        if (10'000 * difference > rays)
            throw std::runtime_error(std::to_string(difference) + " of " + std::to_string(rays) +
                                     " rays meet something else by bare Embree");
    }

private:
    struct Packet {
        RTCRay8 ray;
        alignas(32) int valid[kPacket];
    };
    struct Batch {
        std::vector<Packet> packets;
        std::vector<RTCRay> singles;
        Coherence coherence;
        bool shadow;
    };
    struct Surface {
        const Scene* scene;
        uint32_t instance;
    };

    static RTCIntersectContext context_of(const Batch& batch) {
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        context.flags = batch.coherence == Coherence::Coherent ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT
                                                               : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
        return context;
    }

    void add_instance(const Scene& scene, uint32_t index) {
        const Instance& instance = scene.instances[index];
        const Mesh& mesh = scene.meshes[instance.mesh];
        if (mesh.triangles.empty()) return;
        RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
        auto* positions = static_cast<vec3*>(rtcSetNewGeometryBuffer(
            geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, sizeof(vec3), mesh.positions.size()));
        for (size_t k = 0; k < mesh.positions.size(); ++k)
            positions[k] = instance.identity ? mesh.positions[k] : instance.to_world * vec4(mesh.positions[k], 1.0f);
        rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, mesh.triangles.data(), 0,
                                   sizeof(uvec3), mesh.triangles.size());
        if (scene.materials[mesh.material].alpha_mode != AlphaMode::Opaque) {
            surfaces_.push_back({&scene, index});
            rtcSetGeometryUserData(geometry, &surfaces_.back());
            rtcSetGeometryIntersectFilterFunction(geometry, &BareEmbree::drop_holes);
            rtcSetGeometryOccludedFilterFunction(geometry, &BareEmbree::drop_holes);
        }
        rtcCommitGeometry(geometry);
        rtcAttachGeometryByID(embree_scene_, geometry, index);
        rtcReleaseGeometry(geometry);
    }

    /// Masked texels are no surface. (Blended ones, which the scenes measured do not have, would all be.)
    static void drop_holes(const RTCFilterFunctionNArguments* args) {
        const Surface& surface = *static_cast<const Surface*>(args->geometryUserPtr);
        const Mesh& mesh = surface.scene->meshes[surface.scene->instances[surface.instance].mesh];
        for (unsigned i = 0; i < args->N; ++i)
            if (args->valid[i] &&
                surface_coverage(*surface.scene, mesh, RTCHitN_primID(args->hit, args->N, i),
                                 RTCHitN_u(args->hit, args->N, i), RTCHitN_v(args->hit, args->N, i)) <= 0)
                args->valid[i] = 0;
    }

    static Batch lay_out(const RecordedBatch& recorded) {
        const std::vector<Ray>& rays = recorded.rays;
        Batch batch{{}, {}, recorded.coherence, recorded.shadow};
        batch.packets.resize((rays.size() + kPacket - 1) / kPacket);
        for (Packet& packet : batch.packets) std::memset(&packet, 0, sizeof packet);
        for (size_t i = 0; i < rays.size(); ++i) {
            const Ray& ray = rays[i];
            Packet& packet = batch.packets[i / kPacket];
            const size_t lane = i % kPacket;
            packet.ray.org_x[lane] = ray.origin.x;
            packet.ray.org_y[lane] = ray.origin.y;
            packet.ray.org_z[lane] = ray.origin.z;
            packet.ray.dir_x[lane] = ray.direction.x;
            packet.ray.dir_y[lane] = ray.direction.y;
            packet.ray.dir_z[lane] = ray.direction.z;
            packet.ray.tfar[lane] = ray.t_max;
            packet.ray.mask[lane] = ~0u;
            packet.valid[lane] = -1;
            RTCRay single{};
            single.org_x = ray.origin.x, single.org_y = ray.origin.y, single.org_z = ray.origin.z;
            single.dir_x = ray.direction.x, single.dir_y = ray.direction.y, single.dir_z = ray.direction.z;
            single.tfar = ray.t_max;
            single.mask = ~0u;
            batch.singles.push_back(single);
        }
        return batch;
    }

    RTCDevice device_;
    RTCScene embree_scene_;
    std::vector<Surface> surfaces_;
    std::vector<Batch> batches_;
};

}  // namespace photond
