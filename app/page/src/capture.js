// SPDX-License-Identifier: Apache-2.0
// Pictures and films of the view with its labels, as files.

const kFilm_Hz = 30;
const kFilms = ['video/webm;codecs=vp9', 'video/webm;codecs=vp8', 'video/webm'];

/** One label as it looks: its box, its edge and its text. `place`: of the picture in the window. */
function drawLabel(context, element, place) {
  const box = element.getBoundingClientRect();
  const style = getComputedStyle(element);
  if (box.width === 0 || style.visibility === 'hidden' || !element.textContent) return;
  const [x, y] = [box.left - place.left, box.top - place.top];
  const edge = parseFloat(style.borderLeftWidth) || 0;
  const round = () => {
    context.beginPath();
    context.roundRect(x, y, box.width, box.height, parseFloat(style.borderTopLeftRadius) || 0);
  };
  round();
  context.fillStyle = style.backgroundColor;
  context.fill();
  if (edge > 0) {
    context.save();
    round();
    context.clip();
    context.fillStyle = style.borderLeftColor;
    context.fillRect(x, y, edge, box.height);
    context.restore();
  }
  context.font = `${style.fontWeight} ${style.fontSize} ${style.fontFamily}`;
  context.textBaseline = 'middle';
  context.fillStyle = style.color;
  context.fillText(element.textContent, x + edge + (parseFloat(style.paddingLeft) || 0), y + box.height / 2);
}

/** Draws a canvas that was rendered in this task, and `labels` over it, into another one. */
function compose(image, canvas, labels) {
  if (image.width !== canvas.width || image.height !== canvas.height) {
    image.width = canvas.width; // which wipes it
    image.height = canvas.height;
  }
  const place = canvas.getBoundingClientRect();
  const context = image.getContext('2d');
  context.setTransform(1, 0, 0, 1, 0, 0);
  context.drawImage(canvas, 0, 0);
  context.scale(canvas.width / place.width, canvas.height / place.height);
  for (const label of labels()) drawLabel(context, label, place);
}

function save(blob, name) {
  const link = document.createElement('a');
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}

export class Capture {
  #film = null;

  /** `labels()`: the elements that are shown over the picture; `name()`: of the file, without its ending. */
  constructor(picture, labels, name) {
    Object.assign(this, {picture, labels, name});
  }

  /** Saves what is seen as a PNG file. */
  async shoot() {
    const image = document.createElement('canvas');
    this.picture.draw();
    compose(image, this.picture.canvas, this.labels);
    save(await new Promise((done) => image.toBlob(done, 'image/png')), `${this.name()}.png`);
  }

  get filming() {
    return this.#film !== null;
  }

  /** Begins a film, or ends it and saves it as a WebM file. Throws if the browser makes none. */
  toggleFilm() {
    if (this.#film) return this.#film.recorder.stop();
    const type = kFilms.find((name) => globalThis.MediaRecorder?.isTypeSupported(name));
    if (!type) throw new Error('this browser records no films');
    const image = document.createElement('canvas');
    compose(image, this.picture.canvas, this.labels);
    const recorder = new MediaRecorder(image.captureStream(kFilm_Hz), {mimeType: type, videoBitsPerSecond: 8e6});
    const pieces = [];
    recorder.ondataavailable = ({data}) => pieces.push(data);
    recorder.onstop = () => {
      this.#film = null;
      save(new Blob(pieces, {type: 'video/webm'}), `${this.name()}.webm`);
    };
    recorder.start(1000);
    this.#film = {recorder, image};
    this.picture.request();
  }

  /** The picture was drawn just now, in this task. */
  drawn() {
    if (this.#film) compose(this.#film.image, this.picture.canvas, this.labels);
  }
}
