// SPDX-License-Identifier: Apache-2.0
// Saves a picture of both methods next to each other, with their names, for a review or a report.
const PICTURE_BAND = 34; // height of a line of text, in pixels

/**
 * Returns a Blob of PNG: the pictures of both sides in full, `names` above them and `lines` below. `drawSide(split)`
 * draws one side on `canvas`: 1 the left one, 0 the right one.
 */
function pictureOfBoth(canvas, names, lines, drawSide) {
  const { width, height } = canvas, gap = 4;
  const sheet = document.createElement("canvas");
  sheet.width = 2 * width + gap;
  sheet.height = height + PICTURE_BAND * (1 + lines.length);
  const context = sheet.getContext("2d");
  context.fillStyle = "#15191d";
  context.fillRect(0, 0, sheet.width, sheet.height);
  [1, 0].forEach((split, side) => {
    drawSide(split);
    context.drawImage(canvas, side * (width + gap), PICTURE_BAND);
  });
  context.fillStyle = "#e3e7ea";
  context.textBaseline = "middle";
  const write = (text, x, y, wide) => {
    context.font = `${Math.round(0.5 * PICTURE_BAND)}px system-ui, sans-serif`;
    context.fillText(text, x + 10, y + PICTURE_BAND / 2, wide - 20); // a longer text is made narrower
  };
  names.forEach((name, side) => write(name, side * (width + gap), 0, width));
  lines.forEach((line, i) => write(line, 0, height + PICTURE_BAND * (1 + i), sheet.width));
  return new Promise((resolve, reject) => sheet.toBlob((blob) => (blob === null
    ? reject(new Error("this browser made no PNG of it")) : resolve(blob)), "image/png"));
}

/** Gives a file to the browser, as if it were downloaded. */
function saveFile(blob, name) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 60000); // a browser may still ask where to put it
}
