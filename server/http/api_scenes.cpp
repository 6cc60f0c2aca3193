// Scenes: those that jobs may name, and those that clients bring.
#include "http/api.h"
#include "http/file_answer.h"
#include "http/guard.h"
#include "http/query.h"
#include "io/io_error.h"
#include "io/sha256.h"
#include "scene/scene_library.h"

namespace probebake {
namespace {

constexpr int kMaxUploads = 2;

std::string_view type_of(const SceneFile& file) {
    if (file.generator) return "generator";
    if (file.mesh) return name_of(file.mesh->format);
    return file.vox ? "vox" : "heightmap";
}

Json write_scene(const SceneFile& file) {
    Json json = {{"name", file.name},
                 {"type", type_of(file)},
                 {"description", file.description},
                 {"author", file.author},
                 {"licence", file.licence},
                 {"voxel_size_m", file.voxel_size_m},
                 {"origin_m", {file.origin_m.x, file.origin_m.y, file.origin_m.z}}};
    if (file.generator) {
        json["generator"] = file.generator->name;
        json["size"] = file.generator->size;
        json["seed"] = file.generator->seed;
    }
    if (file.mesh) {
        // Of a resolution, the size is known when the mesh is.
        if (file.mesh->resolution) json["resolution"] = *file.mesh->resolution;
        json["voxel_size_m"] = file.mesh->voxel_size_m ? Json(*file.mesh->voxel_size_m) : Json();
    }
    return json;
}

std::string scene_name(const PathParams& params) { return params.at("name"); }

[[noreturn]] void refuse(int status, std::string code, std::string detail) {
    throw ProblemError({.status = status, .code = std::move(code), .detail = std::move(detail)});
}

/// The body in a temporary file, which is the one that was announced.
void receive(const httplib::Request& request, const httplib::ContentReader& body,
             TemporaryFile& file) {
    Sha256 sha;
    std::exception_ptr failure;
    const bool whole = body([&](const char* bytes, size_t size) {
        try {
            const auto part = std::as_bytes(std::span(bytes, size));
            sha.update(part);
            file.write(part);
            return true;
        } catch (...) {  // not through the library
            failure = std::current_exception();
            return false;
        }
    });
    if (failure) std::rethrow_exception(failure);
    if (!whole) refuse(408, "too-slow", "the body did not arrive in time");
    const std::string digest = repr_digest(sha.hex());
    if (request.get_header_value("Repr-Digest") != digest) {
        refuse(422, "digest-mismatch", "what arrived has the digest " + digest);
    }
}

}  // namespace

/// A scene file as clients see it; a broken one with what is wrong about it.
Json Api::describe_scene(const std::string& name) const {
    Json json;
    try {
        const std::optional<SceneFile> file = parts_.scenes.find(name);
        json = file ? write_scene(*file) : Json{{"name", name}, {"error", "the file is gone"}};
    } catch (const std::exception& error) {
        json = {{"name", name}, {"error", error.what()}};
    }
    json["uploaded"] = !parts_.scenes.owns(name);
    return json;
}

void Api::list_scenes(const Call& call) {
    QueryReader(call.request).refuse_unknown();
    Json scenes = Json::array();
    for (const std::string& name : parts_.scenes.names()) scenes.push_back(describe_scene(name));
    answer_json({{"scenes", std::move(scenes)}}, call.response);
}

void Api::scene(const Call& call) {
    QueryReader(call.request).refuse_unknown();
    const std::string name = scene_name(call.params);
    if (!parts_.scenes.owns(name) && !parts_.uploads.has(name)) {
        refuse(404, "unknown-scene", "there is no scene of that name");
    }
    Json json = describe_scene(name);
    if (!json.contains("error")) {
        try {
            json["sha256"] = content_sha256(parts_.scenes.find(name).value());
        } catch (const std::exception& error) {
            json["error"] = error.what();
        }
    }
    answer_json(json, call.response);
}

void Api::upload_scene(const Call& call) {
    QueryReader(call.request).refuse_unknown();
    const std::string name = scene_name(call.params);
    // By the target, too: an encoded name passed the guard as something else, with other limits.
    if (!is_name(name) || !is_upload(call.request.method, call.request.target)) {
        refuse(404, "unknown-scene", "expected a name that matches [a-z0-9][a-z0-9._-]{0,63}");
    }
    if (call.request.get_header_value("Repr-Digest").rfind("sha-256=:", 0) != 0) {
        refuse(400, "digest-required",
               "expected the header \"Repr-Digest: sha-256=:...:\", of the body");
    }
    if (parts_.scenes.owns(name)) {
        refuse(409, "scene-exists", "the service's own library has a scene of that name");
    }
    if (parts_.jobs.draining()) throw ServiceBusy("draining", "the service ends");
    // The archive and what is unpacked of it.
    const auto bytes = std::stoull(call.request.get_header_value("Content-Length"));
    if (parts_.store.data().free_bytes() < parts_.min_free_bytes + 2 * bytes) {
        throw ServiceBusy("disk-full", "there is no room on the disk for it");
    }
    const Place place(uploads_, kMaxUploads, "too-many-uploads");
    TemporaryFile archive(parts_.store.data());
    receive(call.request, *call.upload, archive);
    try {
        const bool replaced = parts_.uploads.put(name, archive.path(), parts_.end);
        call.response.status = replaced ? 200 : 201;
    } catch (const Cancelled&) {
        throw ServiceBusy("draining", "the service ends");
    } catch (const IoError& error) {
        throw SpecError(SpecError::Kind::kUnacceptable, "", error.what());
    }
    call.response.set_header("Location", "/v1/scenes/" + name);
    answer_json(describe_scene(name), call.response);
}

void Api::remove_scene(const Call& call) {
    QueryReader(call.request).refuse_unknown();
    const std::string name = scene_name(call.params);
    if (!parts_.uploads.has(name)) {
        if (parts_.scenes.owns(name)) {
            refuse(409, "not-uploaded", "the scene belongs to the service's own library");
        }
        refuse(404, "unknown-scene", "there is no scene of that name");
    }
    parts_.uploads.remove(name);
    call.response.status = 204;
}

}  // namespace probebake
