"""Write all made files of the models anew."""

from vipr.models import model_path
from vipr.models.build import board, objects, robots

folder = model_path("package.xml").parent
robots.write(folder)
objects.write(folder)
board.write(folder)
