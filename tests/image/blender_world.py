"""Renders what cameras see of an equirectangular world: blender ... -- MAP.exr PREFIX.

Writes PREFIX0.exr, ... in the order of DIRECTIONS (Blender's axes), linear, nothing but the world.
"""
import sys

import bpy
from mathutils import Vector

DIRECTIONS = [(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1), (1, 2, 3), (-2, 1, 1)]

picture, prefix = sys.argv[sys.argv.index("--") + 1:]
bpy.ops.wm.read_factory_settings(use_empty=True)
scene = bpy.context.scene
scene.world = bpy.data.worlds.new("world")
scene.world.use_nodes = True
nodes = scene.world.node_tree.nodes
links = scene.world.node_tree.links
nodes.clear()
texture = nodes.new("ShaderNodeTexEnvironment")
texture.image = bpy.data.images.load(picture)
texture.projection = "EQUIRECTANGULAR"
background = nodes.new("ShaderNodeBackground")
output = nodes.new("ShaderNodeOutputWorld")
links.new(texture.outputs["Color"], background.inputs["Color"])
links.new(background.outputs["Background"], output.inputs["Surface"])

camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
camera.data.angle = 0.0175
scene.collection.objects.link(camera)
scene.camera = camera
scene.render.engine = "CYCLES"
scene.cycles.device = "CPU"
scene.cycles.samples = 1
scene.render.resolution_x = scene.render.resolution_y = 9
scene.render.resolution_percentage = 100
scene.render.image_settings.file_format = "OPEN_EXR"
scene.render.image_settings.color_depth = "32"
for index, direction in enumerate(DIRECTIONS):
    camera.rotation_mode = "QUATERNION"
    camera.rotation_quaternion = Vector(direction).to_track_quat("-Z", "Y")
    scene.render.filepath = f"{prefix}{index}.exr"
    bpy.ops.render.render(write_still=True)
