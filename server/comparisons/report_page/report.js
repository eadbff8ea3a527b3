"use strict";
// The wipe: two of the page's pictures over each other, parted where the pointer is. Without this script the pictures
// stand beside each other below.
(() => {
  const pictures = [...document.querySelectorAll("img[data-picture]")];
  if (pictures.length < 2) return;
  const [wipe, stage, under, over, line, slider] =
    ["wipe", "wipe-stage", "wipe-under", "wipe-over", "wipe-line", "wipe-at"].map((id) => document.getElementById(id));

  function part(share) {
    const percent = `${100 * Math.min(1, Math.max(0, share))}%`;
    over.style.clipPath = `inset(0 0 0 ${percent})`;
    line.style.left = percent;
  }
  function choose(image, select) {
    const picture = pictures[select.selectedIndex];
    image.src = picture.src;
    image.alt = picture.alt;
  }
  for (const [id, image, start] of [["wipe-left", under, 0], ["wipe-right", over, 1]]) {
    const select = document.getElementById(id);
    select.append(...pictures.map((picture) => new Option(picture.dataset.picture)));
    select.selectedIndex = start;
    select.addEventListener("change", () => choose(image, select));
    choose(image, select);
  }
  slider.addEventListener("input", () => part(slider.value / slider.max));
  const follow = (event) => {
    if (event.pointerType !== "mouse" && !stage.hasPointerCapture(event.pointerId)) return;
    const box = stage.getBoundingClientRect();
    const share = (event.clientX - box.left) / box.width;
    slider.value = share * slider.max;
    part(share);
  };
  stage.addEventListener("pointerdown", (event) => { stage.setPointerCapture(event.pointerId); follow(event); });
  stage.addEventListener("pointermove", follow);
  part(0.5);
  wipe.hidden = false;
})();
