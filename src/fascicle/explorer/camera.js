// Turns the camera by the pointer or the slider, and back with a double click; the slider follows
// the pointer, and the camera the slider. Arguments: camera, slider, azimuth, elevation (at first).
const data = camera.data;
const turn = (azimuth, elevation) => {
  camera.data = {azimuth: [azimuth], elevation: [elevation]};
  slider.value = Math.round(azimuth);
};
switch (cb_obj.event_name) {
  case "panstart":
    camera.grip = data;
    break;
  case "pan": {
    const {azimuth: [az], elevation: [el]} = camera.grip;  // when the pointer went down
    const turned = az - 0.5 * cb_obj.delta_x;
    turn(((turned + 180) % 360 + 360) % 360 - 180,
         Math.max(-89, Math.min(89, el + 0.5 * cb_obj.delta_y)));
    break;
  }
  case "doubletap":
    turn(azimuth, elevation);
    break;
  default:  // the slider
    if (Math.round(data.azimuth[0]) !== slider.value) turn(slider.value, data.elevation[0]);
}
